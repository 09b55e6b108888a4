"""`Guidance`: the modification of the control law that guidance selects."""

import dataclasses as dc
import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.controller.program.kernels.tick_arrays import (
    GuidanceArrays,
)
from remosplat_drake.controller.program.path import Path


@dc.dataclass(frozen=True)
class Guidance:
    """A modification of the control law; the default is no modification.

    Attributes:
        name: Name of the guidance, for display.
        side: Side on which the robot passes obstacles: +1 for left, -1 for
            right, 0 for neither.
        bearing: Desired bearing psi of the end effector in the base's frame,
            positive to the left [rad]. With a negative bearing, the base heads
            to the left of the end effector.
        active_scale: Factor of the gain of the active collision cost.
        stopping: Stopping distance d_s [m]; None keeps the configured one.
        path: Path through configurations that the robot follows, instead of the
            servo's direct way to the target; None if there is no path.
        joint_stop: Stopping distance of revolute joints from their limits
            [deg]; None keeps the configured one.
        slide_stop: Stopping distance of prismatic joints from their limits [m];
            None keeps the configured one.
        approach_scale: Factor of the gain of the collision damper.
    """

    name: str = "direct"
    side: float = 0.0
    bearing: float = 0.0
    active_scale: float = 1.0
    stopping: float | None = None
    path: Path | None = None
    joint_stop: float | None = None
    slide_stop: float | None = None
    approach_scale: float = 1.0

    def __deepcopy__(self, memo) -> "Guidance":
        return self

    @cached_property
    def arrays(self) -> Packed[GuidanceArrays]:
        """The guidance, packed for kernels."""
        path, joint_stop = self.path, self.joint_stop
        arrays = GuidanceArrays(
            float(self.side),
            float(self.bearing),
            float(self.active_scale),
            _or_nan(self.stopping),
            float(self.approach_scale),
            math.nan if joint_stop is None else math.radians(joint_stop),
            _or_nan(self.slide_stop),
            np.zeros((0, 0)) if path is None else path.q,
            np.zeros(0) if path is None else path.s,
            np.zeros(0) if path is None or path.v is None else path.v,
            np.zeros((0, 2)) if path is None or path.a is None else path.a,
        )
        return Packed(arrays)


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else float(value)


DIRECT = Guidance()
"""The `Guidance` that does not modify the control law."""


def make_candidates(
    tiers: Sequence[float], bearing: float = 0.8, active_scale: float = 0.5
) -> tuple[tuple[Guidance, ...], ...]:
    """Makes the candidates direct, left and right for each stopping distance.

    Args:
        tiers: Stopping distances in the order in which they may be tried,
            largest first [m].
        bearing: Angle by which the base is turned away from the direction to
            the end effector, towards the chosen side [rad].
        active_scale: Factor of the active collision cost for the candidates
            left and right.

    Returns:
        A tuple of candidates for each tier, in the order of `tiers`.
    """
    return tuple(
        (
            Guidance("direct", stopping=tier),
            Guidance("left", 1.0, -bearing, active_scale, tier),
            Guidance("right", -1.0, bearing, active_scale, tier),
        )
        for tier in tiers
    )
