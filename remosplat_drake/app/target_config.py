"""`TargetConfig`: a target pose of an end effector, in a scenario file."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval, Len

from remosplat_drake.base.errors import unknown_name
from remosplat_drake.base.pose_config import PoseConfig, make_transform
from remosplat_drake.base.ranges import OneOf, joined
from remosplat_drake.signals.target import (
    DIRECTIONS,
    Line,
    Target,
    weights_problem,
)


@dc.dataclass
class TargetConfig(PoseConfig):
    """A target pose of an end effector, with free directions and a speed."""

    # Name of the end effector; empty for the first end effector. Each end
    # effector has its own sequence of targets, and does not wait for other end
    # effectors.
    effector: str = ""
    # Directions in which the error is ignored: `x`, `y`, `z` along the axes of
    # the pose, and rotations `rx`, `ry`, `rz` about them. One or all of the
    # rotations may be free: [rz] for a screw about the tool's axis, [rx, ry,
    # rz] for a position without orientation.
    free: Annotated[
        list[Annotated[str, OneOf(DIRECTIONS, "direction")]], Len(0, 6)
    ] = dc.field(default_factory=list)
    # Relative weights of the errors by direction; 1 for directions without an
    # entry. They matter if the target cannot be reached in all directions.
    weights: dict[str, Annotated[float, Interval(gt=0, le=1000)]] = dc.field(
        default_factory=dict
    )
    # Distance at which the target counts as passed [m]: the end effector
    # continues to the next target without a stop. Absent: the end effector
    # reaches the target and holds it.
    pass_within: Annotated[float, Interval(gt=0, le=1)] | None = None
    # Speed along a straight line to the target [m/s]. The line begins at the
    # end effector's position when the target becomes active. Absent: the path
    # is free.
    line_speed: Annotated[float, Interval(gt=0, le=2)] | None = None

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the directions exist and can be free together.

        Yields:
            The name of a field and its problem.
        """
        yield from super().check()
        for name in self.weights:
            if name not in DIRECTIONS:
                yield "weights", unknown_name("direction", name, DIRECTIONS)
                return
            if name in self.free:
                yield (
                    joined("weights", name),
                    ("is a free direction and cannot have a weight"),
                )
        problem = weights_problem(self.weighed())
        if problem:
            yield "free", problem

    def weighed(self) -> np.ndarray:
        """Returns the weights of the six directions, 0 for a free one, (6,)."""
        return np.array(
            [
                0.0 if name in self.free else self.weights.get(name, 1.0)
                for name in DIRECTIONS
            ]
        )


def make_target(config: TargetConfig, where: str, field: str) -> Target:
    """Makes the target of a scenario's entry.

    Args:
        config: The entry.
        where: File and name of the scenario, for errors.
        field: Name of the entry's field, for errors.

    Raises:
        FieldError: The entry is unusable.
    """
    X_WT = make_transform(config, where, field).GetAsMatrix4()
    line = None
    if config.line_speed is not None:
        line = Line(
            X_WT, config.line_speed
        )  # The line starts at the motion's start.
    return Target(X_WT, config.weighed(), line, config.pass_within)
