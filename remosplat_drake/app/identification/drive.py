"""Sends identifying commands to the real robot, guarded, and records them."""

import dataclasses as dc
import time
from collections.abc import Callable

import numpy as np

from remosplat_drake.app.hardware_limits import COMMANDED_MODES
from remosplat_drake.app.hardware_run import bring_to_rest
from remosplat_drake.app.identification.fit import LONGEST_GAP, Recording
from remosplat_drake.base.clock import sleep_until
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.real_time import (
    CONTROLLER_PRIORITY,
    garbage_collection_disabled,
    realtime_priority,
)
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.hardware.client.measurement import Measurement
from remosplat_drake.hardware.client.robot_link import RobotLink
from remosplat_drake.hardware.client.status_monitor import station_status
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.oracle.uncertain_placement import UncertainPlacement
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.station_status import StationStatus

_STATUS_TIMEOUT = 0.003


class DisturbedError(RemoSplatError):
    """A computer was late, ours or the robot's: the same may end well again."""


@dc.dataclass(frozen=True, eq=False)
class Reading:
    """What the drivers have last told of the robot.

    Attributes:
        measurement: The states of its parts.
        stamps: When each axis was measured, shape (n_u,) [s].
        q: Configuration at these stamps, with a base where its odometry has
            it, shape (n_q,) [m, rad].
        q_W: The same, with a base where it is in the map; NaN while that is
            not known, shape (n_q,) [m, rad].
    """

    measurement: Measurement
    stamps: np.ndarray
    q: np.ndarray
    q_W: np.ndarray

    def seen(self, field: DistanceField) -> DistanceField:
        """Returns a map as it may lie about a base that is uncertain."""
        track = self.measurement.base_track
        if not len(track.samples):
            return field
        return UncertainPlacement(field, self.q_W[:2], *track.uncertainty)


def read_robot(
    link: RobotLink, robot: RobotModel, before: Measurement
) -> Reading:
    """Fetches the newest statuses.

    Args:
        link: The link to the robot's drivers.
        robot: The robot.
        before: The measurement so far.

    Raises:
        RemoSplatError: A part has not been heard of.
    """
    now = link.updated(before)
    if now.arm is None or (robot.n_base and now.base is None):
        raise RemoSplatError("not all parts of the robot have been heard of")
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
) -> tuple[StationStatus, str]:
    """Tells whether the robot may move.

    Args:
        reading: What its drivers have last told.
        robot: The robot.
        config: Expiry times of the drivers.

    Returns:
        Its status, and why it must not move; empty if it may.
    """
    now, has_base = reading.measurement, robot.n_base > 0
    status = station_status(now, config, has_base, time.time())
    reason = status.stop_reason
    if not reason and status.robot_mode not in COMMANDED_MODES:
        reason = f"the arm's mode is {status.robot_mode}"
    return status, reason


def await_robot(
    link: RobotLink, robot: RobotModel, config: HardwareConfig
) -> Reading:
    """Listens until the robot may move, and it is known where it is.

    A localisation tells that only after some fixes.

    Args:
        link: The link to the robot's drivers.
        robot: The robot.
        config: Expiry times of the drivers, and the longest wait.

    Raises:
        RemoSplatError: The robot may not move; the text says why.
    """
    link.wait_for_statuses()
    deadline = time.monotonic() + config.connect_timeout
    reading = read_robot(link, robot, Measurement())
    while True:
        _, reason = robot_stop(reading, robot, config)
        if not reason:
            return reading
        if time.monotonic() > deadline:
            raise RemoSplatError(f"identify: {reason}")
        link.flush(_STATUS_TIMEOUT)
        reading = read_robot(link, robot, reading.measurement)


def drive(
    link: RobotLink,
    robot: RobotModel,
    config: HardwareConfig,
    commands: np.ndarray,
    period: float,
    problem: Callable[[Reading], str],
) -> Recording:
    """Sends commands, one a period, and records what comes of them.

    However it ends, the robot is brought to rest. A base is recorded by its
    odometry: corrections by a localisation are no motion.

    Args:
        link: The link to the robot's drivers.
        robot: The robot.
        config: Expiry times of the drivers.
        commands: The commands, shape (k, n_u) [m/s, rad/s].
        period: Control period [s].
        problem: Says why the robot must not go on; empty if it may.

    Raises:
        DisturbedError: The robot stopped after a command or a status was late.
        RemoSplatError: The robot stopped, came too near to something, or
            somebody interrupted.
    """
    rows = []
    with (
        stop_signals() as request,
        realtime_priority(CONTROLLER_PRIORITY),
        garbage_collection_disabled(),
    ):
        try:
            link.period = period
            reading = await_robot(link, robot, config)
            due = time.time() + period
            for u in commands:
                sleep_until(due, period)
                due += period
                link.flush(_STATUS_TIMEOUT)
                reading = read_robot(link, robot, reading.measurement)
                status, reason = robot_stop(reading, robot, config)
                if reason:
                    sent = [row[0] for row in rows]
                    late = _was_late(status, config, sent)
                    kind = DisturbedError if late else RemoSplatError
                    raise kind(f"identify: {reason}")
                why = "interrupted" if request.made else problem(reading)
                if why:
                    raise RemoSplatError(f"identify: {why}; the robot stopped")
                link.send(u)
                rows.append((link.sent, link.u, reading.stamps, reading.q))
        finally:
            request.is_heeded = True
            bring_to_rest(link, robot.acceleration_limit, period)
    sent, u, stamp, q = (np.array(column) for column in zip(*rows, strict=True))
    return Recording(sent, u, stamp, q)


def _was_late(
    status: StationStatus, config: HardwareConfig, sent: list[float]
) -> bool:
    """Whether a stop may come of statuses or commands that came late.

    Args:
        status: The status that tells the stop.
        config: Expiry times of the drivers.
        sent: When commands were sent so far [s].
    """
    gaps = np.diff([*sent, time.time()])
    return (
        status.age > config.arm_status_limit
        or status.base_age >= config.base_status_expiry
        or bool((gaps > LONGEST_GAP).any())
    )
