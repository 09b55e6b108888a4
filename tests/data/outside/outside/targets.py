"""Targets: one that is found from where the robot is when it starts."""

import dataclasses as dc
from typing import Annotated

import numpy as np
from annotated_types import Interval
from pydrake.math import RigidTransform
from pydrake.systems.framework import LeafSystem

from remosplat_drake.base.ranges import Config
from remosplat_drake.task.target_sequence import TargetSequence


@dc.dataclass
class Ahead(Config):
    """A target so far before the end effector of the robot at home."""

    distance: Annotated[float, Interval(ge=0, le=100)] = 0.1

    def make(self, robot, arrival, period) -> TargetSequence:
        """Makes the system."""
        X_WE = robot.end_effector_pose(np.array([0, 0, 0, *robot.home]))
        X_WE[0, 3] += self.distance
        return TargetSequence(
            robot=robot,
            X_WTs=[RigidTransform(X_WE)],
            arrival=arrival,
            period=period,
        )


@dc.dataclass
class Nowhere(Config):
    """Makes a system without a port."""

    def make(self, robot, arrival, period) -> LeafSystem:
        """Makes the system."""
        return LeafSystem()
