"""When a target counts as reached."""

import dataclasses as dc
import math
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base.ranges import Config, OneOf
from remosplat_drake.robot.pose_error import PoseError

RULES = ("text", "authors")


@dc.dataclass
class ArrivalConfig(Config):
    """The success rule (paper section V, "Success Rate")."""

    # `text`: distance and angle, as the paper says. `authors`: the L1 norm
    # of the translation alone, as their code does.
    rule: Annotated[str, OneOf(RULES, "rule")] = "text"
    # Tolerance on the position [m].
    position: Annotated[float, Interval(gt=0, le=1)] = 0.02
    # Tolerance on the rotation [deg].
    angle: Annotated[float, Interval(gt=0, le=180)] = 2.0


def has_arrived(error: PoseError, config: ArrivalConfig) -> bool:
    """Whether a pose error counts as arrival."""
    if config.rule == "authors":
        return error.distance_l1 < config.position
    return error.distance < config.position and error.angle < math.radians(
        config.angle
    )
