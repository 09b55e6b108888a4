"""Settings of a simulated robot's sensors for movers (moving objects).

A sensor gets the true movers, and computes those that the robot knows. A sensor
with cameras has a period, so its results may be old.
"""

import dataclasses as dc
from typing import Protocol

import numpy as np

from remosplat_drake.base.ranges import Config
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.primitive_scene import PrimitiveScene


class MoverSensor(Protocol):
    """The interface of a simulated sensor for movers."""

    @property
    def period(self) -> float:
        """Time between two measurements [s]; 0: the sensor is continuous."""
        ...

    def sense(self, truth: Movers, q: np.ndarray) -> Movers:
        """Measures once, and returns the known movers.

        Args:
            truth: All true movers, stamped with the present time.
            q: The robot's configuration, shape (n_q,).
        """
        ...


class MoverSensing(Protocol):
    """The interface of settings that make a `MoverSensor`.

    In a scenario, a class of another package is `!package.module:Class`.
    """

    def make(
        self, robot: RobotModel, scene: PrimitiveScene | None
    ) -> MoverSensor | None:
        """Makes the sensor of a run; None if the robot never senses movers.

        Args:
            robot: The robot, which a camera sees, too.
            scene: The true static solids; None if they are unknown.
        """
        ...


@dc.dataclass
class KnownMovers(Config):
    """Settings of a sensor that measures exact poses and twists of movers."""

    def make(
        self, robot: RobotModel, scene: PrimitiveScene | None
    ) -> MoverSensor:
        """Makes a sensor that returns the truth."""
        del robot, scene
        return _TrueMovers(at_rest=False)


@dc.dataclass
class StandingMovers(Config):
    """Settings of a sensor that measures poses of movers, but no motion.

    The robot then treats movers as static obstacles. This is for comparisons
    only.
    """

    def make(
        self, robot: RobotModel, scene: PrimitiveScene | None
    ) -> MoverSensor:
        """Makes a sensor without velocities."""
        del robot, scene
        return _TrueMovers(at_rest=True)


@dc.dataclass
class UnknownMovers(Config):
    """Settings for a robot that senses no movers, for comparisons only."""

    def make(self, robot: RobotModel, scene: PrimitiveScene | None) -> None:
        """Makes no sensor."""
        del robot, scene


@dc.dataclass(frozen=True)
class _TrueMovers:
    at_rest: bool
    period: float = 0.0

    def sense(self, truth: Movers, q: np.ndarray) -> Movers:
        """Returns the true movers, with or without motion."""
        del q
        if not self.at_rest:
            return truth
        return Movers(truth.stamp, [without_motion(m) for m in truth])


def without_motion(mover: Mover) -> Mover:
    """Returns a mover at rest, whose bounds on its motion are zero."""
    return dc.replace(
        mover,
        v_WM=np.zeros(3),
        w_WM=np.zeros(3),
        max_speed=0.0,
        max_acceleration=0.0,
    )
