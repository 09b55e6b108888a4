"""`ReachingTask`: what a trial must know of a scene, however it was made."""

import dataclasses as dc
from collections.abc import Callable
from functools import cached_property
from typing import Protocol

from pydrake.math import RigidTransform

from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

TRAINED, SURFEL, NO_SPLAT = "trained", "surfel", "none"
"""Where a splat comes from, as every table says."""


@dc.dataclass(frozen=True, eq=False)
class ReachingTask:
    """A target in a scene whose true distances are known.

    Attributes:
        X_WE_target: End-effector pose to reach.
        X_WB_start: Base pose to start from as (x, y, yaw) [m, rad].
        content_hash: A digest of the true geometry.
        measure_truth: Makes the field that collisions are judged by.
        solids: The true geometry as solids, where it is known like that.
    """

    X_WE_target: RigidTransform
    X_WB_start: tuple[float, float, float]
    content_hash: str
    measure_truth: Callable[[], DistanceField]
    solids: PrimitiveScene | None = None

    @cached_property
    def truth_field(self) -> DistanceField:
        """The true distances, made when they are first asked for."""
        return self.measure_truth()


def solid_task(scene: PrimitiveScene) -> ReachingTask:
    """The task of a scene of solids, which must have one."""
    assert scene.X_WE_target is not None and scene.X_WB_start is not None
    return ReachingTask(
        scene.X_WE_target,
        scene.X_WB_start,
        scene.content_hash,
        lambda: SignedDistanceField(scene),
        scene,
    )


class BenchmarkCase(Protocol):
    """One scene and target of a suite, small enough for a worker."""

    @property
    def name(self) -> str:
        """As tables show it."""
        ...

    @property
    def family(self) -> str:
        """Cases of a family are reported together."""
        ...

    @property
    def suite(self) -> str:
        """What the cases are, for titles."""
        ...

    def task(self) -> ReachingTask:
        """The target and the truth about the scene.

        Raises:
            RemoSplatError: A file cannot be used, or there is no task.
        """
        ...

    def splat_key(self) -> str:
        """Names the splat's content, without making it."""
        ...

    def splat(self) -> tuple[GaussianSplat, str]:
        """The map in W, and where it comes from, as every table says."""
        ...
