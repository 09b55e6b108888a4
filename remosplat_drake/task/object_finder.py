"""`ObjectFinder`: finds objects of a static map for an operator."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.found_object import find_object_at
from remosplat_drake.scene.objects.scene_object import SceneObject, new_name
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.task.task import TaskState


@dc.dataclass(frozen=True, eq=False)
class NewObject:
    """An object that was found in a map, and the rest of the map.

    Attributes:
        thing: The object.
        scene: The map without the object's Gaussians.
    """

    thing: SceneObject
    scene: SceneMap

    @property
    def text(self) -> str:
        """Name, shape, size and assumed mass, in a sentence's words."""
        lower, upper = self.thing.corners
        x, y, z = 1e3 * (upper - lower)
        kind = type(self.thing.solid).__name__
        shape = {"ConvexHull": "convex hull"}.get(kind, kind.lower())
        return (
            f"{self.thing.name} is a {shape} of {x:.0f} x {y:.0f} x {z:.0f} mm,"
            f" {self.thing.mass:g} kg assumed"
        )


@dc.dataclass(frozen=True, eq=False)
class ObjectFinder:
    """Finds objects of a static map for an operator.

    Attributes:
        make_field: Function that makes the distance field of a splat in W.
        mass: Mass that is assumed for the objects [kg].
        largest: Largest extent of an object along each axis of W [m].
        refusal: Reason why no object can be found in this run; empty if
            objects can be found.
    """

    make_field: Callable[[GaussianSplat], DistanceField]
    mass: float
    largest: float
    refusal: str = ""

    def find(
        self,
        near: np.ndarray,
        scene: SceneMap | None,
        state: TaskState,
    ) -> NewObject:
        """Finds the object at a point, and names it.

        Args:
            near: A point on the object in W, shape (3,) [m].
            scene: The map without the known objects; None if the map changes
                during the run.
            state: The state of the task, with the known objects.

        Raises:
            RemoSplatError: There is no such object, or none can be found in
                this run; the text states the reason.
        """
        if self.refusal:
            raise RemoSplatError(self.refusal)
        if scene is None or scene.splat_W is None:
            raise RemoSplatError("the map has no splat")
        splat_W = scene.splat_W
        found = find_object_at(
            splat_W,
            near,
            self.largest,
            new_name([each.name for each in state.objects]),
            self.mass,
            [each for each in state.in_map if each.name not in state.lost],
        )
        rest_W = splat_W.select(~found.own)
        rest = dc.replace(
            scene, field=self.make_field(rest_W), splat_W=rest_W, tiles=()
        )
        return NewObject(found.thing, rest)
