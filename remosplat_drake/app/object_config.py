"""`ObjectConfig`: an object of a scenario: its shape, pose and splats."""

import dataclasses as dc
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import numpy as np
from annotated_types import Interval, Len

from remosplat_drake.app.object_map import OWN_MARGIN, own_splats
from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.pose_config import PoseConfig, make_transform
from remosplat_drake.base.ranges import Config, Position, joined
from remosplat_drake.oracle.found_object import FoundObject, find_object_at
from remosplat_drake.scene.objects.convex_hull import ConvexHull, read_hull
from remosplat_drake.scene.objects.level_surface import find_level_surface
from remosplat_drake.scene.objects.scene_object import SceneObject, Solid
from remosplat_drake.scene.primitive_scene import Box, Cylinder
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.shortest_axes import shortest_axes

Size = Annotated[float, Interval(gt=0, le=100)]
"""Type of an object's lengths [m], with the valid range."""

SHAPES = ("box", "cylinder", "hull", "surface", "region")
"""Fields of `ObjectConfig` that define its shape. An object has exactly one of
these fields."""


@dc.dataclass
class CylinderShape(Config):
    """A cylinder along the object's z axis."""

    # Its radius [m].
    radius: Size = 0.03
    # Its height [m].
    height: Size = 0.1


@dc.dataclass
class HullShape(Config):
    """The convex hull of a mesh."""

    # The mesh file (.obj, .gltf or .vtk), relative to the scenario's.
    file: str = ""
    # Metres per unit of the file [m].
    scale: Annotated[float, Interval(ge=1e-6, le=1e6)] = 1.0


@dc.dataclass
class SurfaceShape(Config):
    """A level surface in the splat, on which objects are placed.

    A rectangle of the surface, along the axes x and y of W, becomes the top of
    a thin box.
    """

    # A point x, y, z in W at the surface [m].
    near: Position = dc.field(default_factory=lambda: [0.0, 0.0, 0.0])
    # Largest distance of the rectangle from this point, along x and y [m].
    reach: Annotated[float, Interval(ge=0.05, le=5)] = 0.3


@dc.dataclass
class RegionShape(Config):
    """The connected Gaussians of the splat that stand around a point.

    A box, a cylinder or a convex hull is fitted around them.
    """

    # A point x, y, z in W on the object [m].
    near: Position = dc.field(default_factory=lambda: [0.0, 0.0, 0.0])
    # Largest extent of the object along each axis of W [m].
    largest: Annotated[float, Interval(ge=0.02, le=2)] = 0.4


@dc.dataclass
class ObjectConfig(Config):
    """An object that a hand may grasp, or that supports other objects."""

    # Unique name of the object. Solids of this name in the true scene represent
    # the object.
    name: Annotated[str, Len(1, 60)] = "object"
    # Pose of the object's frame O in W; O is in the middle of a box or a
    # cylinder.
    X_WO: PoseConfig = dc.field(default_factory=PoseConfig)
    # The three side lengths of a box [m].
    box: Annotated[list[Size], Len(3, 3)] | None = None
    cylinder: CylinderShape | None = None
    hull: HullShape | None = None
    # A place on a level surface in the splat; such an object has no X_WO.
    surface: SurfaceShape | None = None
    # A point on the object in the splat; such an object has no X_WO.
    region: RegionShape | None = None
    # Mass of the object [kg]; absent: unknown.
    mass: Annotated[float, Interval(gt=0, le=1000)] | None = None
    # Whether the splat contains the object. If not, only its shape represents
    # it.
    in_splat: bool = True
    # Largest distance from the object's surface at which a splat belongs to it
    # [m]. A region has exactly its own splats.
    margin: Annotated[float, Interval(ge=0, le=0.1)] = OWN_MARGIN

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that a region is in the splat."""
        if self.region is not None and not self.in_splat:
            yield "in_splat", "must be true, since a region is in the splat"


def make_objects(
    configs: Sequence[ObjectConfig],
    folder: Path,
    where: str,
    splat_W: GaussianSplat | None = None,
) -> tuple[FoundObject, ...]:
    """Makes the objects of a scenario, and finds their splats.

    Args:
        configs: The objects of the scenario.
        folder: Folder that relative file names refer to.
        where: File and name of the scenario, for errors.
        splat_W: The scene's splat in W, in which surfaces and regions are
            searched; None without a splat.

    Raises:
        FieldError: A file is unusable, an object does not have exactly one
            shape, two objects have the same name or region, or the splat shows
            no level surface or no region at a place.
    """
    splat_W = splat_W or GaussianSplat.empty()
    found: list[FoundObject] = []
    for i, config in enumerate(configs):
        field = f"objects[{i}]"
        if any(config.name == other.thing.name for other in found):
            problem = f"two objects are named {config.name!r}"
            raise FieldError(where, joined(field, "name"), problem)
        try:
            found.append(_found(config, folder, where, field, splat_W))
        except FieldError:
            raise
        except RemoSplatError as error:
            raise FieldError(where, field, str(error)) from error
    _check_regions(configs, found, where)
    return tuple(found)


def _check_regions(
    configs: Sequence[ObjectConfig], found: Sequence[FoundObject], where: str
) -> None:
    """Checks that most splats of a region belong to no other object."""
    for i, (config, each) in enumerate(zip(configs, found, strict=True)):
        if config.region is None:
            continue
        for other in found:
            shared = np.count_nonzero(each.own & other.own)
            if other is not each and 2 * shared > np.count_nonzero(each.own):
                raise FieldError(
                    where,
                    f"objects[{i}].region.near",
                    f"the Gaussians there belong to the {other.thing.name};"
                    " remove one of the two objects, or correct the point",
                )


def _found(
    config: ObjectConfig,
    folder: Path,
    where: str,
    field: str,
    splat_W: GaussianSplat,
) -> FoundObject:
    given = [shape for shape in SHAPES if getattr(config, shape) is not None]
    if len(given) != 1:
        problem = f"give exactly one of {', '.join(SHAPES)}, got {len(given)}"
        raise FieldError(where, field, problem)
    if config.region is not None:
        near, largest = np.array(config.region.near), config.region.largest
        with _located(where, joined(field, "region.near")):
            _check_splat(splat_W)
            return find_object_at(
                splat_W, near, largest, config.name, config.mass
            )
    solid = _solid(config, folder, where, field, splat_W)
    thing = SceneObject(config.name, solid, config.mass)
    own = np.zeros(len(splat_W), bool)
    if config.in_splat and len(splat_W):
        own = own_splats(splat_W, thing, config.margin)
    return FoundObject(thing, own)


def _solid(
    config: ObjectConfig,
    folder: Path,
    where: str,
    field: str,
    splat_W: GaussianSplat,
) -> Solid:
    X_WO = make_transform(config.X_WO, where, joined(field, "X_WO"))
    if config.box is not None:
        return Box(X_WO, np.array(config.box) / 2.0, config.name)
    if config.cylinder is not None:
        shape = config.cylinder
        return Cylinder(X_WO, shape.radius, shape.height / 2.0, config.name)
    if config.surface is not None:
        with _located(where, joined(field, "surface.near")):
            _check_splat(splat_W)
            return find_level_surface(
                np.asarray(splat_W.p_GK, float),
                shortest_axes(splat_W),
                np.array(config.surface.near),
                config.surface.reach,
                config.name,
            )
    assert config.hull is not None
    file = resources.resolve(config.hull.file, folder)
    return ConvexHull(X_WO, read_hull(file, config.hull.scale), config.name)


@contextmanager
def _located(where: str, field: str) -> Iterator[None]:
    """Adds a field's name to errors of the `with` block."""
    try:
        yield
    except RemoSplatError as error:
        raise FieldError(where, field, str(error)) from error


def _check_splat(splat_W: GaussianSplat) -> None:
    if not len(splat_W):
        raise RemoSplatError("needs a splat; set scene.splat, or give a box")
