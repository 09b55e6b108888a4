"""Sends identifying commands to the real robot, guarded, and records them."""

import time
from collections.abc import Callable

import numpy as np

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
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_status as modes
from remosplat_drake.signals.station_status import StationStatus

_STATUS_TIMEOUT = 0.003


class DisturbedError(RemoSplatError):
    """A computer was late, ours or the robot's: the same may end well again."""


def measured(
    link: RobotLink, robot: RobotModel, before: Measurement
) -> tuple[Measurement, np.ndarray, np.ndarray]:
    """Fetches the newest statuses.

    Args:
        link: The link to the robot's drivers.
        robot: The robot.
        before: The measurement so far.

    Returns:
        The measurement, the configuration at its stamps, shape (n_q,), and
        the stamps of the axes, shape (n_u,) [s].

    Raises:
        RemoSplatError: A part has not been heard of.
    """
    now = link.updated(before)
    if now.arm is None or (robot.n_base and now.base is None):
        raise RemoSplatError("not all parts of the robot have been heard of")
    q, stamps = now.arm.q, [now.arm.stamp] * len(now.arm.q)
    if now.base is not None and robot.n_base:
        q = np.concatenate([now.base.pose, q])
        stamps = [now.base.stamp] * robot.n_base + stamps
    return now, q, np.array(stamps)


def drive(
    link: RobotLink,
    robot: RobotModel,
    config: HardwareConfig,
    commands: np.ndarray,
    period: float,
    is_safe: Callable[[np.ndarray], bool],
) -> Recording:
    """Sends commands, one a period, and records what comes of them.

    However it ends, the robot is brought to rest.

    Args:
        link: The link to the robot's drivers.
        robot: The robot.
        config: Expiry times of the drivers.
        commands: The commands, shape (k, n_u) [m/s, rad/s].
        period: Control period [s].
        is_safe: Tells whether the robot may go on at a configuration.

    Raises:
        DisturbedError: The robot stopped after a command or a status was late.
        RemoSplatError: The robot stopped, came too near to something, or
            somebody interrupted.
    """
    rows, now = [], Measurement()
    with (
        stop_signals() as request,
        realtime_priority(CONTROLLER_PRIORITY),
        garbage_collection_disabled(),
    ):
        try:
            link.wait_for_statuses()
            due = time.time() + period
            for u in commands:
                sleep_until(due, period)
                due += period
                link.flush(_STATUS_TIMEOUT)
                now, q, stamp = measured(link, robot, now)
                status = station_status(
                    now, config, robot.n_base > 0, time.time()
                )
                if status.mode != modes.RUNNING:
                    sent = [row[0] for row in rows]
                    late = _was_late(status, config, sent)
                    kind = DisturbedError if late else RemoSplatError
                    raise kind(f"identify: {status.stop_reason}")
                if request.made or not is_safe(q):
                    why = "interrupted" if request.made else "too near"
                    raise RemoSplatError(f"identify: {why}; the robot stopped")
                link.send(u)
                rows.append((link.sent, link.u, stamp, q))
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
        status.age > config.arm_status_expiry
        or status.base_age >= config.base_status_expiry
        or bool((gaps > LONGEST_GAP).any())
    )
