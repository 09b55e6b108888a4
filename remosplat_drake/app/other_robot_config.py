"""`OtherRobot`: a second simulated robot near the first one."""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.ranges import Config, OneOf
from remosplat_drake.station.robot_movers import MOST_ACCELERATION

OURS, THEIRS, NOBODYS = "ours", "theirs", "nobodys"
"""Choices of the robot with right of way."""


@dc.dataclass
class OtherRobot(Config):
    """A robot that another scenario drives, in the same simulation.

    Each of the two robots is a mover for the other. Without a right of way,
    both wait where they meet, possibly forever.
    """

    # Its display name.
    name: Annotated[str, Len(1, 40)] = "robot"
    # The scenario that drives it: NAME of a shipped one, or FILE:NAME, relative
    # to this file's folder. It has its own start, map and targets; its `movers`
    # are ignored.
    scenario: Annotated[str, Len(1)] = "TableReach"
    # The robot with right of way: that of this scenario ("ours"), the other one
    # ("theirs"), or neither ("nobodys").
    right_of_way: Annotated[str, OneOf((OURS, THEIRS, NOBODYS))] = OURS
    # Distance that the yielding robot keeps from the other one [m]; it retreats
    # if the other comes nearer.
    yielding: Annotated[float, Interval(gt=0, le=1)] = 0.3
    # Assumed speed limit of all points of a robot, for the other robot [m/s].
    max_speed: Annotated[float, Interval(gt=0, le=100)] = 1.5
    # Assumed acceleration limit of all points of a robot, for the other robot
    # [m/s^2].
    max_acceleration: Annotated[float, Interval(gt=0, le=1000)] = (
        MOST_ACCELERATION
    )
