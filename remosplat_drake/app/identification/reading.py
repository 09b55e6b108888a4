"""Receives the drivers' statuses while `remosplat identify` runs."""

import dataclasses as dc
import time
from collections.abc import Sequence

import numpy as np

from remosplat_drake.app.hardware_limits import COMMANDED_MODES
from remosplat_drake.app.identification.fit import Recording
from remosplat_drake.app.velocity_run import Played
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.client.measurement import Measurement
from remosplat_drake.hardware.client.robot_link import RobotLink
from remosplat_drake.hardware.client.status_monitor import station_status
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.oracle.uncertain_placement import UncertainPlacement
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField

_STATUS_TIMEOUT = 0.003


@dc.dataclass(frozen=True, eq=False)
class Reading:
    """The latest states that the drivers have sent.

    Attributes:
        measurement: The states of the robot's parts.
        stamps: Time of each axis' measurement, shape (n_u,) [s].
        q: Configuration at these stamps, with the base's pose by odometry,
            shape (n_q,) [m, rad].
        q_W: Configuration at these stamps, with the base's pose in the map,
            shape (n_q,) [m, rad]; NaN while this pose is unknown.
    """

    measurement: Measurement
    stamps: np.ndarray
    q: np.ndarray
    q_W: np.ndarray

    def seen(self, field: DistanceField) -> DistanceField:
        """Returns a map that allows for the uncertainty of the base's pose."""
        track = self.measurement.base_track
        if not len(track.samples):
            return field
        return UncertainPlacement(field, self.q_W[:2], *track.uncertainty)


def reading_of(now: Measurement, robot: RobotModel) -> Reading:
    """Makes a `Reading` from the latest statuses of a robot's parts.

    Args:
        now: The latest statuses.
        robot: The robot.

    Raises:
        RemoSplatError: The arm or the base has sent no status yet.
    """
    if now.arm is None or (robot.n_base and now.base is None):
        raise RemoSplatError(
            "a part of the robot has not sent a status yet; check that all "
            "drivers run"
        )
    q, stamps = now.arm.q, [now.arm.stamp] * len(now.arm.q)
    if now.base is None or not robot.n_base:
        return Reading(now, np.array(stamps), q, q)
    X_OB, X_WB = now.base.pose, now.base_track.pose(now.base.pose)
    return Reading(
        now,
        np.array([now.base.stamp] * robot.n_base + stamps),
        np.concatenate([X_OB, q]),
        np.concatenate([X_WB, q]),
    )


def robot_stop(
    reading: Reading, robot: RobotModel, config: HardwareConfig
) -> str:
    """Returns the reason why the robot must not move; "" if it may move.

    Args:
        reading: The latest states of the robot's drivers.
        robot: The robot.
        config: Settings of the drivers, with the statuses' expiry times.
    """
    now, has_base = reading.measurement, robot.n_base > 0
    status = station_status(now, config, has_base, time.time())
    reason = status.stop_reason
    if not reason and status.robot_mode not in COMMANDED_MODES:
        reason = f"the arm's mode is {status.robot_mode}"
    return reason


def await_robot(
    link: RobotLink, robot: RobotModel, config: HardwareConfig
) -> Reading:
    """Listens until the robot may move and its pose in the map is known.

    A localisation reports the pose only after some measurements.

    Args:
        link: The link to the robot's drivers.
        robot: The robot.
        config: Settings of the drivers, with the statuses' expiry times and the
            longest wait.

    Raises:
        RemoSplatError: The robot was not allowed to move before the longest
            wait had passed; the text states the reason.
    """
    link.wait_for_statuses()
    deadline = time.monotonic() + config.connect_timeout
    reading = reading_of(link.updated(Measurement()), robot)
    while True:
        reason = robot_stop(reading, robot, config)
        if not reason:
            return reading
        if time.monotonic() > deadline:
            raise RemoSplatError(f"identify: {reason}")
        link.flush(_STATUS_TIMEOUT)
        reading = reading_of(link.updated(reading.measurement), robot)


def recording_of(ticks: Sequence[Played], robot: RobotModel) -> Recording:
    """Returns the ticks of a velocity profile as a recording.

    The base's motion is taken from its odometry, since a correction by a
    localisation is not a motion.

    Args:
        ticks: The ticks, at least one.
        robot: The robot.
    """
    readings = [reading_of(tick.measurement, robot) for tick in ticks]
    return Recording(
        sent=np.array([tick.sent for tick in ticks]),
        u=np.array([tick.u for tick in ticks]),
        stamp=np.array([reading.stamps for reading in readings]),
        q=np.array([reading.q for reading in readings]),
        n_base=robot.n_base,
    )
