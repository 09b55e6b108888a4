"""`OtherRobot`: a second simulated robot near the first robot."""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.ranges import Config, OneOf
from remosplat_drake.station.robot_movers import MOST_ACCELERATION

OURS, THEIRS, NOBODYS = "ours", "theirs", "nobodys"
"""Choices of `right_of_way`: the robot of the scenario, the other robot, or
neither of them."""


@dc.dataclass
class OtherRobot(Config):
    """A robot that another scenario drives, in the same simulation.

    Each of the two robots is a moving obstacle for the other robot. If neither
    robot has right of way, both may wait forever where they meet.
    """

    # Its display name.
    name: Annotated[str, Len(1, 40)] = "robot"
    # The scenario that drives the other robot: NAME of a shipped scenario, or
    # FILE:NAME, relative to this file's folder. That scenario has its own
    # start, map and targets; its `movers` are ignored.
    scenario: Annotated[str, Len(1)] = "TableReach"
    # The robot with right of way: this scenario's robot ("ours"), the other
    # robot ("theirs"), or neither ("nobodys").
    right_of_way: Annotated[str, OneOf((OURS, THEIRS, NOBODYS))] = OURS
    # Distance that the robot without right of way keeps from the robot with
    # right of way [m]. It retreats if that robot comes nearer.
    yielding: Annotated[float, Interval(gt=0, le=1)] = 0.3
    # Speed limit that each robot assumes for all points of the other robot
    # [m/s].
    max_speed: Annotated[float, Interval(gt=0, le=100)] = 1.5
    # Acceleration limit that each robot assumes for all points of the other
    # robot [m/s^2].
    max_acceleration: Annotated[float, Interval(gt=0, le=1000)] = (
        MOST_ACCELERATION
    )
