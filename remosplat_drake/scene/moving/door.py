"""`SwingingDoor`: a door with a fixed hinge, as configured in a scenario."""

import dataclasses as dc
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy
from annotated_types import Interval, Len
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.ranges import AngleDeg, Config, Position
from remosplat_drake.scene.mover import Mover
from remosplat_drake.scene.moving.track import SLACK, time_goes_on

Side = Annotated[float, Interval(gt=0, le=10)]


@dc.dataclass
class DoorAngle(Config):
    """The angle of a door at a time."""

    # Time since the run began [s].
    time: Annotated[float, Interval(ge=0, le=1e6)] = 0.0
    # Angle about the upward axis from W's x axis to the door [deg].
    angle_deg: AngleDeg = 0.0


@dc.dataclass
class SwingingDoor(Config):
    """A door: a box that turns about a vertical hinge at one of its edges.

    The door is at rest at the first and the last angle, and swings smoothly
    through the angles between them.
    """

    # Its display name.
    name: str = "door"
    # Foot of the hinge in W [m].
    hinge: Position = dc.field(default_factory=lambda: [0.0] * 3)
    # Width, from the hinge to the opposite edge [m].
    width: Side = 0.9
    # Height, from the hinge's foot to the upper edge [m].
    height: Side = 2.0
    # Thickness [m].
    thickness: Annotated[float, Interval(gt=0, le=1)] = 0.04
    # Angles of the door over time; with a single angle, it does not move.
    angles: Annotated[list[DoorAngle], Len(1, 1000)] = dc.field(
        default_factory=lambda: [DoorAngle()]
    )
    # Speed limit of all points of the door, as reported to the robot [m/s];
    # absent: the largest actual speed.
    max_speed: Annotated[float, Interval(ge=0, le=100)] | None = None
    # Acceleration limit of all points of the door, as reported to the robot
    # [m/s^2]; absent: the largest actual acceleration.
    max_acceleration: Annotated[float, Interval(ge=0, le=1000)] | None = None

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that times increase.

        Yields:
            The name of a field and what is wrong with it.
        """
        yield from time_goes_on("angles", [a.time for a in self.angles])

    def make(self, folder: Path) -> "DoorTrack":
        """Makes the door's track.

        Args:
            folder: Unused, since there are no files.
        """
        del folder
        return DoorTrack(self)


class DoorTrack:
    """The pose of a door at any time.

    Args:
        config: The door.
    """

    def __init__(self, config: SwingingDoor):
        self.config = config
        self._times = np.array([a.time for a in config.angles])
        angles = np.radians([a.angle_deg for a in config.angles])
        if len(angles) == 1:
            self._times = self._times[0] + np.array([0.0, 1.0])
            angles = np.repeat(angles, 2)
        self._angle = scipy.interpolate.CubicSpline(
            self._times, angles, bc_type="clamped"
        )
        # The outer edge is the fastest part; between two angles, rate and
        # acceleration are polynomials of low degree.
        looks = np.concatenate(
            [np.linspace(a, b, 50) for a, b in pairwise(self._times)]
        )
        rate, change = self._angle(looks, 1), self._angle(looks, 2)
        arm = np.hypot(config.width, config.thickness)
        self._speed = SLACK * arm * float(np.abs(rate).max())
        self._push = SLACK * arm * float(np.hypot(change, rate**2).max())

    def movers(self, time: float) -> list[Mover]:
        """Returns the door at a time.

        Args:
            time: Time since the run began [s].
        """
        config = self.config
        now = float(np.clip(time, self._times[0], self._times[-1]))
        rate = float(self._angle(now, 1)) if now == time else 0.0
        X_WH = RigidTransform(
            RotationMatrix.MakeZRotation(float(self._angle(now))), config.hinge
        )
        half = 0.5 * np.array([config.width, config.thickness, config.height])
        X_WM = X_WH @ RigidTransform([half[0], 0.0, half[2]])
        w_WM = np.array([0.0, 0.0, rate])
        v_WM = np.cross(w_WM, X_WM.translation() - X_WH.translation())
        speed, push = config.max_speed, config.max_acceleration
        return [
            Mover(
                config.name,
                X_WM,
                half,
                0.0,
                v_WM,
                w_WM,
                self._speed if speed is None else speed,
                self._push if push is None else push,
            )
        ]
