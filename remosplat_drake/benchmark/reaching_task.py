"""`ReachingTask`: target, start and true geometry of a trial's scene."""

import dataclasses as dc
from collections.abc import Callable
from functools import cached_property
from typing import Protocol

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.contact_rules import ContactRule, reliefs
from remosplat_drake.oracle.object_field import ObjectField, with_objects
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

TRAINED, SURFEL, NO_SPLAT = "trained", "surfel", "none"
"""Names of the origins of a splat, for tables."""


@dc.dataclass(frozen=True, eq=False)
class ReachingTask:
    """A target in a scene whose true distances are known.

    Attributes:
        X_WE_target: Target pose of the end effector in W.
        X_WB_start: Start pose of the base in W as (x, y, yaw) [m, m, rad].
        content_hash: Digest of the true geometry.
        measure_truth: Function that makes the distance field for the detection
            of collisions.
        solids: The true geometry as solids; None if it does not consist of
            known solids.
        arm_start: Joint positions at which the arm starts [rad]; None means its
            home posture.
        start_field: Name of the field of the scene's file that contains the
            start, for errors.
        arm_goal: Joint positions of an arm on a fixed base at the target [rad];
            None if they are not given.
        grasped: Solids of the object that the hand encloses at the target. Only
            the hand may touch them. Empty if there is no such object, or if the
            scene does not contain it.
        support: If the robot must carry the object to the start's pose: the
            solid under the object, one of `solids`. None otherwise.
        further_targets: Target poses in W of the robot's further end effectors,
            in order; empty if only the first end effector has a target.
    """

    X_WE_target: RigidTransform
    X_WB_start: tuple[float, float, float]
    content_hash: str
    measure_truth: Callable[[], DistanceField]
    solids: PrimitiveScene | None = None
    arm_start: tuple[float, ...] | None = None
    start_field: str = "robot_base"
    arm_goal: tuple[float, ...] | None = None
    grasped: tuple[SceneObject, ...] = ()
    support: SceneObject | None = None
    further_targets: tuple[RigidTransform, ...] = ()

    @property
    def X_WTs(self) -> np.ndarray:
        """Target poses of the e end effectors with targets, (e, 4, 4)."""
        targets = (self.X_WE_target, *self.further_targets)
        return np.array([X_WT.GetAsMatrix4() for X_WT in targets])

    @cached_property
    def truth_field(self) -> DistanceField:
        """The field of true distances, which is made on first access."""
        return self.measure_truth()

    def with_grasped(
        self, field: DistanceField, robot: RobotModel
    ) -> DistanceField:
        """Adds the grasped object to a field, for all links except the hand's.

        Args:
            field: Distances to all other surfaces.
            robot: The robot.
        """
        if not self.grasped:
            return field
        names, hand = [each.name for each in self.grasped], hand_links(robot)
        rules = [ContactRule(name, hand) for name in names]
        relief = reliefs(rules, robot.spheres.links, names, 0.0)
        return with_objects(field, ObjectField(self.grasped, relief))


def solid_task(scene: PrimitiveScene) -> ReachingTask:
    """Makes the task of a scene of solids, which must have a target."""
    assert scene.X_WE_target is not None and scene.X_WB_start is not None
    return ReachingTask(
        scene.X_WE_target,
        scene.X_WB_start,
        scene.content_hash,
        lambda: SignedDistanceField(scene),
        scene,
    )


class BenchmarkCase(Protocol):
    """One scene and target of a suite, small enough to be sent to a worker."""

    @property
    def name(self) -> str:
        """Name of the case in tables."""
        ...

    @property
    def file(self) -> str:
        """Path of the case's file; empty if it has none."""
        ...

    @property
    def family(self) -> str:
        """Family of the case; cases of a family are reported together."""
        ...

    @property
    def suite(self) -> str:
        """Name of the suite in titles of tables."""
        ...

    def task(self) -> ReachingTask:
        """Returns the target, and the true geometry of the scene.

        Raises:
            RemoSplatError: A file cannot be used, or contains no task.
        """
        ...

    def splat_key(self) -> str:
        """Returns a key that identifies the splat, without making the splat."""
        ...

    def splat(self) -> tuple[GaussianSplat, str]:
        """Returns the map in W, and the name of its origin for tables."""
        ...


def known_solids(case: BenchmarkCase) -> PrimitiveScene | None:
    """Returns a case's true solids; None if it has none or cannot be used."""
    try:
        return case.task().solids
    except RemoSplatError:
        return None
