"""`ArrivalConfig`: the rule by which a target counts as reached."""

import dataclasses as dc
import math
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base.ranges import Config, OneOf
from remosplat_drake.robot.pose_error import PoseError

RULES = ("text", "authors")
"""Success rules: the rule in the paper's text, and the rule in its authors'
code."""


@dc.dataclass
class ArrivalConfig(Config):
    """Conditions for arrival at a target (paper section V, "Success Rate")."""

    # Success rule. `text` is the rule in the paper: distance and angle must be
    # within their tolerances. `authors` is the rule in the authors' code: only
    # the L1 norm of the translation must be within its tolerance.
    rule: Annotated[str, OneOf(RULES, "rule")] = "text"
    # Greatest distance between end effector and target [m].
    position: Annotated[float, Interval(gt=0, le=1)] = 0.02
    # Greatest angle between end effector and target [deg].
    angle: Annotated[float, Interval(gt=0, le=180)] = 2.0


def has_arrived(error: PoseError, config: ArrivalConfig) -> bool:
    """Returns whether a pose error is within the tolerances.

    Args:
        error: The error from the end effector to the target.
        config: The success rule and its tolerances.
    """
    if config.rule == "authors":
        return error.distance_l1 < config.position
    return error.distance < config.position and error.angle < math.radians(
        config.angle
    )
