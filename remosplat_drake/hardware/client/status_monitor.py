"""Computes the station status of a real robot, with reasons to stop."""

import math

from remosplat_drake.hardware.client.base_track import track_problem
from remosplat_drake.hardware.client.measurement import Measurement
from remosplat_drake.hardware.client.stream import (
    Stream,
    StreamLimits,
    stream_problem,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire import panda as panda_wire
from remosplat_drake.hardware.wire.base import BaseState
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.hardware.wire.panda import PandaState
from remosplat_drake.signals.station_status import (
    RUNNING,
    STOPPED,
    StationStatus,
)

_STANDS = {"guiding", "reflex", "user_stopped", "automatic_error_recovery"}
"""Modes in which the arm does not follow commands."""


def station_status(
    measurement: Measurement, config: HardwareConfig, has_base: bool, now: float
) -> StationStatus:
    """Computes the status of the station: whether the robot may move.

    The age of the station status is that of the arm's state. The base's
    odometry has a lower rate. It is extrapolated to the present, and has its
    own expiry time.

    Args:
        measurement: The latest states from the drivers.
        config: Expiry times, and names of the channels, which reasons contain.
        has_base: Whether the robot has a mobile base.
        now: Our wall clock [s].
    """
    arm, base = measurement.arm, measurement.base
    reason = measurement.intruder
    reason = reason or _arm_problem(measurement, config, now)
    if has_base:
        reason = reason or _base_problem(measurement, config, now)
    lost = track_problem(measurement.base_track, config) if has_base else ""
    if arm is None or (has_base and base is None):
        return StationStatus(math.inf, STOPPED, reason, "other", 0.0)
    return StationStatus(
        age=now - arm.stamp,
        mode=STOPPED if reason else RUNNING,
        stop_reason=reason,
        robot_mode=panda_wire.MODE_NAMES[arm.robot_mode],
        success_rate=arm.success_rate,
        protective_stop=base is not None and base.protective_stop,
        base_age=measurement.base_age(now, config.base_status_expiry),
        is_lost=bool(lost) and reason == lost,
        base_uncertainty=tuple(measurement.base_track.uncertainty),
        sent=measurement.sent,
    )


def _arm_problem(
    measurement: Measurement, config: HardwareConfig, now: float
) -> str:
    limits = StreamLimits(config.arm_status_limit, config.frozen_after)
    # The robot's own clock always advances, but joints may be at rest.
    should_change = bool(measurement.arm and measurement.arm.robot_stamp) or (
        now - measurement.moving_since > config.frozen_after
    )
    return _named(
        config.channels.arm_status,
        measurement.arm_stream,
        limits,
        should_change,
        now,
    ) or _arm_stop(measurement.arm)


def _base_problem(
    measurement: Measurement, config: HardwareConfig, now: float
) -> str:
    limits = StreamLimits(config.base_status_expiry, math.inf)
    return (
        _named(
            config.channels.base_status,
            measurement.base_stream,
            limits,
            False,
            now,
        )
        or _base_stop(measurement.base)
        or track_problem(measurement.base_track, config)
    )


def _named(
    channel: str,
    stream: Stream,
    limits: StreamLimits,
    should_change: bool,
    now: float,
) -> str:
    problem = stream_problem(stream, now, limits, should_change)
    return f"{channel}: {problem}" if problem else ""


def _arm_stop(arm: PandaState | None) -> str:
    mode = panda_wire.MODE_NAMES[arm.robot_mode] if arm else ""
    return f"the arm is in mode {mode}" if mode in _STANDS else ""


def _base_stop(base: BaseState | None) -> str:
    if base is None:
        return ""
    if base.emergency_stop:
        return "emergency stop of the base"
    if base.protective_stop:
        return "protective stop of the base"
    if base.mode in (base_status.STOPPED, base_status.FAULT):
        name = "stopped" if base.mode == base_status.STOPPED else "at fault"
        return f"the base is {name}"
    return ""
