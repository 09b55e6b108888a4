"""`RobotRecord`: recorded commands and statuses of a robot, as arrays."""

import collections
import dataclasses as dc
import itertools
from collections.abc import Iterable

import numpy as np
from drake import lcmt_panda_command

from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire import panda as panda_wire
from remosplat_drake.hardware.wire.base import (
    MODE_NAMES,
    base_axes,
    decode_base_status,
)
from remosplat_drake.hardware.wire.lease import DRIVER_REPORT, decode_report
from remosplat_drake.hardware.wire.messages.base_command import base_command
from remosplat_drake.hardware.wire.multicast import Packet
from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    from_utime,
)
from remosplat_drake.robot.base_motion import base_way
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass(frozen=True, eq=False)
class PartRecord:
    """Commands and statuses of one part of a robot, with n axes.

    Attributes:
        part: Name of the part, `arm` or `base`.
        channel: Channel of the part's statuses.
        axes: Names of the part's axes.
        sent: Stamps of the commands, ascending, shape (c,) [s].
        u: The commands, shape (c, n) [rad/s, m/s].
        received: Times of arrival of the statuses, by our clock, shape (k,)
            [s].
        stamp: Times of measurement of the statuses, by the driver's clock,
            shape (k,) [s].
        way: Displacements of the axes since the first status, shape (k, n)
            [rad, m].
        v: Reported velocities, shape (k, n) [rad/s, m/s].
        modes: Reported modes, in the order of their first occurrence.
        obeys: The modes in `modes` in which the part follows commands.
        broken: Numbers of malformed statuses, keyed by their problem.
    """

    part: str
    channel: str
    axes: tuple[str, ...]
    sent: np.ndarray
    u: np.ndarray
    received: np.ndarray
    stamp: np.ndarray
    way: np.ndarray
    v: np.ndarray
    modes: tuple[str, ...]
    obeys: frozenset[str]
    broken: dict[str, int]


@dc.dataclass(frozen=True)
class DriverSession:
    """The time from which to which one process of a driver sent its reports.

    Attributes:
        name: Name of the driver.
        first: Time of arrival of the first report, by our clock [s].
        last: Time of arrival of the last report [s].
    """

    name: str
    first: float
    last: float


def add_session(
    sessions: dict[int, DriverSession], number: int, later: DriverSession
) -> None:
    """Adds a session, or extends the known session of the same number.

    Args:
        sessions: The known sessions, which are changed.
        number: Random number of the session.
        later: The session by reports that came after the known ones.
    """
    known = sessions.setdefault(number, later)
    sessions[number] = dc.replace(known, last=later.last)


def restarted_drivers(sessions: Iterable[DriverSession]) -> list[str]:
    """Lists the drivers that ended and started again.

    Drivers of the same name can run beside each other. A driver restarted if
    one session of its name ended before another one began.

    Returns:
        Names in alphabetical order.
    """
    by_name = collections.defaultdict(list)
    for session in sessions:
        by_name[session.name].append(session)
    return sorted(
        name
        for name, some in by_name.items()
        if min(s.last for s in some) < max(s.first for s in some)
    )


@dc.dataclass(frozen=True, eq=False)
class RobotRecord:
    """Commands and statuses of a robot.

    Attributes:
        arm: Record of the arm.
        base: Record of the base; None for a robot on a fixed base.
        drivers: Sessions of all drivers, keyed by their random numbers.
        duration: Duration of reception [s].
    """

    arm: PartRecord
    base: PartRecord | None
    drivers: dict[int, DriverSession]
    duration: float

    @property
    def parts(self) -> list[PartRecord]:
        """The parts that the robot has."""
        return [self.arm] if self.base is None else [self.arm, self.base]


def gather(
    packets: Iterable[Packet],
    config: HardwareConfig,
    robot: RobotModel,
    duration: float,
) -> RobotRecord:
    """Collects a robot's messages in a record.

    Args:
        packets: The messages, in the order of their arrival.
        config: Settings, with the names of the channels.
        robot: The robot.
        duration: Duration of reception [s].
    """
    by_channel = collections.defaultdict(list)
    for packet in packets:
        by_channel[packet.channel].append(packet)
    names = config.channels
    base = None
    if robot.n_base:
        base = _base_record(
            by_channel[names.base_command],
            by_channel[names.base_status],
            names.base_status,
            robot.n_base,
        )
    arm = _arm_record(
        by_channel[names.arm_command],
        by_channel[names.arm_status],
        names.arm_status,
        tuple(robot.description.arm.joints),
    )
    drivers = _driver_sessions(by_channel[DRIVER_REPORT])
    return RobotRecord(arm, base, drivers, duration)


def _driver_sessions(reports: list[Packet]) -> dict[int, DriverSession]:
    sessions = {}
    for packet in reports:
        try:
            identity = decode_report(packet.data).identity
        except BrokenMessage:
            continue
        new = DriverSession(identity.name, packet.received, packet.received)
        add_session(sessions, identity.session, new)
    return sessions


def _arm_record(
    commands: list[Packet],
    statuses: list[Packet],
    channel: str,
    joints: tuple[str, ...],
) -> PartRecord:
    n, told = len(joints), []
    for packet in commands:
        message = _decoded(lcmt_panda_command, packet.data)
        if message is not None and message.num_joint_velocity == n:
            told.append((message.utime, message.joint_velocity))

    def read(data: bytes):
        state = panda_wire.decode_panda_status(data, n)
        mode = panda_wire.MODE_NAMES[state.robot_mode]
        return state.stamp, state.q, state.v, mode

    rows, modes, broken = _read(statuses, read)
    received, stamp, q, v = _columns(rows, n)
    way = q - q[:1] if len(q) else q
    sent, u = _told(told, n)
    return PartRecord(
        "arm",
        channel,
        joints,
        sent,
        u,
        received,
        stamp,
        way,
        v,
        modes,
        frozenset(("idle", "move")),
        broken,
    )


_BASE = ("forward", "left", "yaw")
_EMERGENCY, _PROTECTIVE = "emergency stop", "protective stop"


def _base_record(
    commands: list[Packet], statuses: list[Packet], channel: str, n: int
) -> PartRecord:
    axes, told = base_axes(n), []
    for packet in commands:
        message = _decoded(base_command, packet.data)
        if message is not None:
            u = np.array([message.forward, message.left, message.yaw_rate])
            told.append((message.utime, u[axes]))

    def read(data: bytes):
        state = decode_base_status(data)
        mode = MODE_NAMES[state.mode]
        mode = _PROTECTIVE if state.protective_stop else mode
        mode = _EMERGENCY if state.emergency_stop else mode
        return state.stamp, state.pose, state.velocity[axes], mode

    rows, modes, broken = _read(statuses, read)
    received, stamp, pose, v = _columns(rows, 3, n)
    steps = [base_way(a, b, n) for a, b in itertools.pairwise(pose)]
    way = np.zeros((len(pose), n))
    if steps:
        way[1:] = np.cumsum(steps, axis=0)
    sent, u = _told(told, n)
    return PartRecord(
        "base",
        channel,
        tuple(_BASE[i] for i in axes),
        sent,
        u,
        received,
        stamp,
        way,
        v,
        modes,
        frozenset(("ready", "moving")),
        broken,
    )


def _decoded(kind, data: bytes):
    try:
        return decode(kind, data)
    except BrokenMessage:
        return None


def _read(statuses: list[Packet], read):
    """Returns rows, modes, and numbers of malformed statuses by their fault."""
    rows, modes, broken = [], {}, collections.Counter()
    for packet in statuses:
        try:
            stamp, q, v, mode = read(packet.data)
        except BrokenMessage as error:
            broken[str(error)] += 1
            continue
        rows.append((packet.received, stamp, q, v))
        modes[mode] = None
    return rows, tuple(modes), dict(broken)


def _columns(rows: list, n_q: int, n_v: int | None = None):
    n_v = n_q if n_v is None else n_v
    received, stamp, q, v = zip(*rows, strict=True) if rows else ((),) * 4
    return (
        np.array(received, float),
        np.array(stamp, float),
        np.array(q, float).reshape(-1, n_q),
        np.array(v, float).reshape(-1, n_v),
    )


def _told(told: list, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Commands in the order of their stamps, without duplicates."""
    by_stamp = dict(sorted((from_utime(utime), u) for utime, u in told))
    u = np.array(list(by_stamp.values()), float).reshape(-1, n)
    return np.array(list(by_stamp), float), u
