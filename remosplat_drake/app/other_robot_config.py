"""`OtherRobot`: a second robot of ours that moves around the first."""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.ranges import Config, OneOf
from remosplat_drake.station.robot_movers import MOST_ACCELERATION

OURS, THEIRS, NOBODYS = "ours", "theirs", "nobodys"
"""Whose the right of way is."""


@dc.dataclass
class OtherRobot(Config):
    """A robot that another scenario drives, in the same simulation.

    Each of the two robots is a mover for the other. Without a right of way both
    wait where they meet, possibly for ever.
    """

    # What people call it.
    name: Annotated[str, Len(1, 40)] = "robot"
    # The scenario that drives it: NAME of a shipped one, or FILE:NAME, with a
    # file beside this one. It has its own start, map and targets; its `movers`
    # do not count.
    scenario: Annotated[str, Len(1)] = "TableReach"
    # Which goes first where both want to: the robot of this scenario ("ours"),
    # the other one ("theirs"), or neither ("nobodys").
    right_of_way: Annotated[str, OneOf((OURS, THEIRS, NOBODYS))] = OURS
    # How far the one that yields keeps from the other [m]: what comes nearer
    # it retreats from.
    yielding: Annotated[float, Interval(gt=0, le=1)] = 0.3
    # No point of a robot ever moves faster, as far as the other is told [m/s].
    max_speed: Annotated[float, Interval(gt=0, le=100)] = 1.5
    # No point of a robot ever accelerates more, as far as the other is told
    # [m/s^2].
    max_acceleration: Annotated[float, Interval(gt=0, le=1000)] = (
        MOST_ACCELERATION
    )
