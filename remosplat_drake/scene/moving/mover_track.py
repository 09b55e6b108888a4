"""`MoverTrack`: the motion of a scenario's mover, as a smooth curve."""

import dataclasses as dc
from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise, product
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy
from annotated_types import Interval, Len
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from remosplat_drake.base.ranges import Config, Position, RollPitchYawDeg
from remosplat_drake.scene.mover import Mover
from remosplat_drake.scene.moving.track import SLACK, time_goes_on

_LOOKS = 200
"""To find the largest speed, the motion between two waypoints is sampled at
this many instants."""

Size = Annotated[float, Interval(ge=0, le=100)]


@dc.dataclass
class WaypointConfig(Config):
    """The pose of a mover at a given time."""

    # Time since the run began [s].
    time: Annotated[float, Interval(ge=0, le=1e6)] = 0.0
    # Position x, y, z of the mover's origin in W [m].
    translation: Position = dc.field(default_factory=lambda: [0.0] * 3)
    # Roll, pitch and yaw of the mover in W, as in Drake's `RollPitchYaw` [deg];
    # absent: zeros.
    rpy_deg: RollPitchYawDeg | None = None

    @property
    def X_WM(self) -> RigidTransform:
        """The pose."""
        angles = np.radians(self.rpy_deg or [0.0] * 3)
        return RigidTransform(
            RotationMatrix(RollPitchYaw(angles)), self.translation
        )


@dc.dataclass
class MoverConfig(Config):
    """A moving object: a rounded box, and its poses over time.

    The object is at rest at the first and the last waypoint, and passes
    smoothly through the waypoints between them. Its rotation stops at each
    waypoint.
    """

    # Its display name.
    name: str = "mover"
    # Half side lengths of the mover's core, which is a box [m]. Three zeros
    # make a sphere; two zeros make a capsule along the third axis.
    half_extents: Annotated[list[Size], Len(3, 3)] = dc.field(
        default_factory=lambda: [0.0] * 3
    )
    # Radius around the core [m].
    radius: Annotated[float, Interval(ge=0, le=10)] = 0.1
    # Poses of the mover over time; with a single pose, it does not move.
    waypoints: Annotated[list[WaypointConfig], Len(1, 1000)] = dc.field(
        default_factory=lambda: [WaypointConfig()]
    )
    # Speed limit of all points of the core, as reported to the robot [m/s];
    # absent: the track's largest speed.
    max_speed: Annotated[float, Interval(ge=0, le=100)] | None = None
    # Acceleration limit of all points of the core, as reported to the robot
    # [m/s^2]; absent: the track's largest acceleration.
    max_acceleration: Annotated[float, Interval(ge=0, le=1000)] | None = None

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the mover has a size, and that times increase.

        Yields:
            The name of a field and what is wrong with it.
        """
        if not self.radius and not all(self.half_extents):
            yield "radius", "must exceed 0 unless all `half_extents` do"
        yield from time_goes_on("waypoints", [w.time for w in self.waypoints])

    def make(self, folder: Path) -> "MoverTrack":
        """Makes the track.

        Args:
            folder: Unused, since there are no files.
        """
        del folder
        return MoverTrack(self)


class MoverTrack:
    """Pose and velocity of a mover at any time.

    Args:
        config: Shape and waypoints of the mover.
    """

    def __init__(self, config: MoverConfig):
        self.config = config
        self._times = np.array([w.time for w in config.waypoints])
        X_WMs = [waypoint.X_WM for waypoint in config.waypoints]
        self._at_rest = X_WMs[0]
        self._position = None
        if len(X_WMs) > 1:
            p_WM = np.array([X.translation() for X in X_WMs])
            self._position = scipy.interpolate.CubicSpline(
                self._times, p_WM, bc_type="clamped"
            )
        self._R_WM = np.array([X.rotation().matrix() for X in X_WMs])
        self._turns_W = [
            b.rotation().multiply(a.rotation().inverse()).ToAngleAxis()
            for a, b in pairwise(X_WMs)
        ]

    def at(self, time: float) -> Mover:
        """Returns the mover at a time, with its bounds.

        Args:
            time: Time since the run began [s].
        """
        speed, acceleration = self._greatest
        config = self.config
        X_WM, v_WM, w_WM = self._motion(time)
        return Mover(
            config.name,
            X_WM,
            np.array(config.half_extents),
            config.radius,
            v_WM,
            w_WM,
            speed if config.max_speed is None else config.max_speed,
            acceleration
            if config.max_acceleration is None
            else config.max_acceleration,
        )

    def movers(self, time: float) -> list[Mover]:
        """Returns a tuple of this mover only, as `Track` requires.

        Args:
            time: Time since the run began [s].
        """
        return [self.at(time)]

    def _motion(
        self, time: float
    ) -> tuple[RigidTransform, np.ndarray, np.ndarray]:
        """Pose, velocity and angular velocity; at rest beyond the ends."""
        none = np.zeros(3)
        if self._position is None:
            return self._at_rest, none, none
        now = min(max(time, self._times[0]), self._times[-1])
        R_WM, w_WM, _ = self._turning(now)
        X_WM = RigidTransform(RotationMatrix(R_WM), self._position(now))
        if now != time:
            return X_WM, none, none
        return X_WM, self._position(now, 1), w_WM

    def _turning(
        self, time: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Orientation, angular velocity, and angular acceleration.

        Between two waypoints, the axis of rotation is constant, and the angle
        is a polynomial of degree five that starts and ends at rest.
        """
        k = int(np.searchsorted(self._times, time, side="right")) - 1
        k = min(max(k, 0), len(self._times) - 2)
        span = self._times[k + 1] - self._times[k]
        x = (time - self._times[k]) / span
        share = x**3 * (10 - 15 * x + 6 * x**2)
        rate = 30 * x**2 * (1 - x) ** 2 / span
        change = 60 * x * (1 - x) * (1 - 2 * x) / span**2
        turn = self._turns_W[k]
        turned = AngleAxis(share * turn.angle(), turn.axis()).rotation()
        turn_W = turn.angle() * turn.axis()
        return turned @ self._R_WM[k], rate * turn_W, change * turn_W

    @cached_property
    def _greatest(self) -> tuple[float, float]:
        """Greatest speed and acceleration of any point of the core."""
        if self._position is None:
            return 0.0, 0.0
        times = np.concatenate(
            [np.linspace(a, b, _LOOKS) for a, b in pairwise(self._times)]
        )
        turnings = zip(*(self._turning(time) for time in times), strict=True)
        R_WM, w_W, spin_W = map(np.array, turnings)
        # Both are greatest at a corner of the core.
        signs = np.array(list(product((-1, 1), repeat=3)))
        lever_W = (signs * self.config.half_extents) @ R_WM.transpose(0, 2, 1)
        turned_W = np.cross(w_W[:, None], lever_W)
        v_W = turned_W + self._position(times, 1)[:, None]
        a_W = self._position(times, 2)[:, None] + (
            np.cross(spin_W[:, None], lever_W)
            + np.cross(w_W[:, None], turned_W)
        )
        speed, push = np.linalg.norm(v_W, axis=2), np.linalg.norm(a_W, axis=2)
        return SLACK * float(speed.max()), SLACK * float(push.max())
