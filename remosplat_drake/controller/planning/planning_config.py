"""`PlanningConfig`: settings of searches for paths."""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base.ranges import Config


@dc.dataclass
class PlanningConfig(Config):
    """Settings of searches for paths through configurations."""

    # Whether a path is searched if no other guidance reaches the target.
    enabled: bool = True
    # Whether a path is also searched as soon as a target is given. The robot
    # follows it if it reaches the target earlier than the direct way.
    at_once: bool = True
    # Number of configurations from which inverse kinematics starts in a search
    # for goal configurations.
    seeds: Annotated[int, Interval(ge=1, le=100_000)] = 1000
    # Largest number of goal configurations of a search.
    goals: Annotated[int, Interval(ge=1, le=1000)] = 6
    # Largest number of motions that the first search checks. Each further
    # attempt may check twice as many motions, with other random numbers.
    checks: Annotated[int, Interval(ge=1, le=10_000_000)] = 1500
    # Number of attempts, each with a search for each stopping distance, after
    # which the target is given up until the target or the map changes.
    attempts: Annotated[int, Interval(ge=1, le=20)] = 4
    # Whether a run ends when a target is given up. If not, it ends at its time
    # limit.
    give_up: bool = False
    # Seed of the searches' random numbers.
    seed: Annotated[int, Interval(ge=0, le=1_000_000)] = 0
    # Stopping distance of revolute joints from their limits on a path, which
    # replaces that of the joint limit damper [deg].
    joint_stop: Annotated[float, Interval(ge=0, le=45)] = 0.1
    # The same for prismatic joints [m].
    slide_stop: Annotated[float, Interval(ge=0, le=0.5)] = 0.001
    # Longest distance that the base may drive backwards without a break [m].
    backing: Annotated[float, Interval(ge=0, le=10)] = 0.5
    # Factor of the gain of the collision damper on a path. It may exceed 1,
    # since paths slow down early.
    approach_scale: Annotated[float, Interval(gt=0, le=10)] = 4.0
    # Largest distance in q from a corner of a path to the ends of its blend, in
    # which a radian counts like a metre. 0 keeps the corners.
    blend: Annotated[float, Interval(ge=0, le=10)] = 1.0
