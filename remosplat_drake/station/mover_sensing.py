"""Settings of a simulated robot's sensors for movers, and these sensors.

A sensor is a function of the truth. One that needs images consists of a period
and a robot with cameras; its results may be old.
"""

import dataclasses as dc
from typing import Protocol

import numpy as np

from remosplat_drake.base.ranges import Config
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.primitive_scene import PrimitiveScene


class MoverSensor(Protocol):
    """Choices of a robot's perception of movers."""

    @property
    def period(self) -> float:
        """Time between two measurements [s]; 0: at every time."""
        ...

    def sense(self, truth: Movers, q: np.ndarray) -> Movers:
        """Measures once, and returns the known movers.

        Args:
            truth: All that moves now; its stamp is the present time.
            q: The robot's configuration, shape (n_q,).
        """
        ...


class MoverSensing(Protocol):
    """Settings that make a sensor: one's own as `!package.module:Class`."""

    def make(
        self, robot: RobotModel, scene: PrimitiveScene | None
    ) -> MoverSensor | None:
        """Makes the sensor of a run; None where nothing is ever known.

        Args:
            robot: The robot, which a camera sees, too.
            scene: The true solids that stand; None where they are unknown.
        """
        ...


@dc.dataclass
class KnownMovers(Config):
    """The robot gets the exact pose and twist of each."""

    def make(
        self, robot: RobotModel, scene: PrimitiveScene | None
    ) -> MoverSensor:
        """Makes a sensor that returns the truth."""
        del robot, scene
        return _Told(standing=False)


@dc.dataclass
class StandingMovers(Config):
    """The robot gets the pose of each, as if all of them stood still.

    This is how obstacles in a map are known, and for comparisons only.
    """

    def make(
        self, robot: RobotModel, scene: PrimitiveScene | None
    ) -> MoverSensor:
        """Makes a sensor without velocities."""
        del robot, scene
        return _Told(standing=True)


@dc.dataclass
class UnknownMovers(Config):
    """The robot senses nothing that moves: for comparisons only."""

    def make(self, robot: RobotModel, scene: PrimitiveScene | None) -> None:
        """Makes no sensor."""
        del robot, scene


@dc.dataclass(frozen=True)
class _Told:
    standing: bool
    period: float = 0.0

    def sense(self, truth: Movers, q: np.ndarray) -> Movers:
        """Returns the true movers, with or without motion."""
        del q
        if not self.standing:
            return truth
        return Movers(truth.stamp, [as_if_standing(m) for m in truth])


def as_if_standing(mover: Mover) -> Mover:
    """Returns a mover without its motion, and without any to come."""
    return dc.replace(
        mover,
        v_WM=np.zeros(3),
        w_WM=np.zeros(3),
        max_speed=0.0,
        max_acceleration=0.0,
    )
