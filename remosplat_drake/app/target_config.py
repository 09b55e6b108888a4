"""`TargetConfig`: a pose for an end effector, in a file."""

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
    """A pose of the end effector, its constrained directions, and the way."""

    # Name of the end effector; empty for the first or only one. Each has
    # its own targets one after the other, and none waits for another.
    effector: str = ""
    # Directions that are free: `x`, `y`, `z` along the axes of the pose, and
    # turns `rx`, `ry`, `rz` about them. Of the turns one or all: [rz] for a
    # screw about the tool's axis, [rx, ry, rz] for a position alone.
    free: Annotated[
        list[Annotated[str, OneOf(DIRECTIONS, "direction")]], Len(0, 6)
    ] = dc.field(default_factory=list)
    # By direction, how much dearer it is to miss it where not all can be had;
    # 1 for those that are not named.
    weights: dict[str, Annotated[float, Interval(gt=0, le=1000)]] = dc.field(
        default_factory=dict
    )
    # Distance at which the target counts as passed, and the end effector goes
    # on to the next without a stop; absent: it is reached and held [m].
    pass_within: Annotated[float, Interval(gt=0, le=1)] | None = None
    # Speed on the straight line that the end effector follows from where it
    # is when the target's turn comes; absent: the way is free [m/s].
    line_speed: Annotated[float, Interval(gt=0, le=2)] | None = None

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the directions exist and can be free together.

        Yields:
            The name of a field and what is wrong with it.
        """
        yield from super().check()
        for name in self.weights:
            if name not in DIRECTIONS:
                yield "weights", unknown_name("direction", name, DIRECTIONS)
                return
            if name in self.free:
                yield joined("weights", name), "is free, and has no weight"
        problem = weights_problem(self.weighed())
        if problem:
            yield "free", problem

    def weighed(self) -> np.ndarray:
        """Returns the weights of all directions, zero where free, (6,)."""
        return np.array(
            [
                0.0 if name in self.free else self.weights.get(name, 1.0)
                for name in DIRECTIONS
            ]
        )


def make_target(config: TargetConfig, where: str, field: str) -> Target:
    """Makes the target that an entry of a scenario stands for.

    Args:
        config: The entry.
        where: The scenario that errors blame, as file and name.
        field: Name of the entry's field, for errors.

    Raises:
        FieldError: The entry is unusable.
    """
    X_WT = make_transform(config, where, field).GetAsMatrix4()
    line = None
    if config.line_speed is not None:
        line = Line(X_WT, config.line_speed)  # It starts where the motion does.
    return Target(X_WT, config.weighed(), line, config.pass_within)
