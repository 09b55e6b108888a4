"""Settings of simulated sensors that detect movers (moving objects).

A sensor computes, from the true movers, the movers that the robot knows. A
sensor with cameras measures periodically, so its latest result may be as old as
its period.
"""

import dataclasses as dc
from typing import Protocol

import numpy as np

from remosplat_drake.base.ranges import Config
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.primitive_scene import PrimitiveScene


class MoverSensor(Protocol):
    """Protocol of a simulated sensor that detects movers."""

    @property
    def period(self) -> float:
        """Time between two measurements [s]; 0 for a continuous sensor."""
        ...

    def sense(self, truth: Movers, q: np.ndarray) -> Movers:
        """Measures once, and returns the movers that the robot knows.

        Args:
            truth: All true movers, stamped with the present time.
            q: The robot's configuration, shape (n_q,).
        """
        ...


class MoverSensing(Protocol):
    """Protocol of settings that make a `MoverSensor`.

    In a scenario, a class of another package is `!package.module:Class`.
    """

    def make(
        self, robot: RobotModel, scene: PrimitiveScene | None
    ) -> MoverSensor | None:
        """Makes the sensor of a run; None if the robot detects no movers.

        Args:
            robot: The robot, which may appear in the images of a camera.
            scene: The true static solids; None if they are unknown.
        """
        ...


@dc.dataclass
class KnownMovers(Config):
    """Settings of a sensor that measures exact poses and twists of movers."""

    def make(
        self, robot: RobotModel, scene: PrimitiveScene | None
    ) -> MoverSensor:
        """Makes a sensor that returns the true movers."""
        del robot, scene
        return _TrueMovers(at_rest=False)


@dc.dataclass
class StandingMovers(Config):
    """Settings of a sensor that measures poses of movers, but no motion.

    The robot then treats movers as static obstacles. These settings are for
    comparisons only.
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
        """Returns None, for no sensor."""
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
    """Returns a mover with zero velocity and zero bounds of its motion."""
    return dc.replace(
        mover,
        v_WM=np.zeros(3),
        w_WM=np.zeros(3),
        max_speed=0.0,
        max_acceleration=0.0,
    )
