"""Checks of the wire: its senders, their rates and their clocks."""

import collections
import contextlib
import dataclasses as dc
import re
import socket
import statistics
import time
from collections.abc import Sequence

from pydrake.lcm import DrakeLcm

from remosplat_drake.hardware.doctor.finding import (
    FAILED,
    SKIPPED,
    Finding,
    judged,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire import base as base_wire
from remosplat_drake.hardware.wire import panda as panda_wire
from remosplat_drake.hardware.wire.base import decode_base_status
from remosplat_drake.hardware.wire.multicast import MulticastListener, Packet
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.hardware.wire.panda import decode_panda_status

PROBE = "REMOSPLAT_DOCTOR"
"""Channel on which the doctor receives itself; no other program uses it."""

LISTENING = 2.0
"""Time for which the wire is listened to [s]."""

_LISTENING_PERIOD = 1e-3

ARM_RATE, BASE_RATE = 200.0, 9.0
"""Least rates of statuses [Hz]; a real arm's is 1 kHz."""

ARM_SHARE = 0.8
"""Least share of an arm's statuses that must arrive, if their rate is lower."""

STAMP_ERROR = 0.02
"""Largest difference between a driver's stamp and our clock, travel included
[s]."""

_COMMANDED = {"arm": ("idle", "move"), "base": ("ready", "moving")}
"""Modes in which the parts of a robot follow commands."""


def check_loopback(url: str) -> Finding:
    """Sends packets to the group and listens whether they come back.

    Args:
        url: LCM URL of the wire.
    """
    heard: list[bytes] = []
    found = "none of its own packets"
    try:
        sender, receiver = DrakeLcm(url), DrakeLcm(url)
        receiver.Subscribe(PROBE, heard.append)
        end = time.monotonic() + LISTENING
        while not heard and time.monotonic() < end:
            sender.Publish(PROBE, b"doctor")
            receiver.HandleSubscriptions(20)
    except RuntimeError as error:
        found = str(error)
    return judged(
        "multicast",
        bool(heard),
        found="this computer receives its own packets" if heard else found,
        wanted="this computer receives its own packets",
        source=f"packets on {PROBE}",
        mend="`ip link set lo multicast on` and `ip route add 224.0.0.0/4 dev"
        " lo`, or the wire's network device in place of lo",
    )


def hear_wire(url: str, duration: float = LISTENING) -> list[Packet]:
    """Listens to all messages of a wire; images are too large to count.

    Args:
        url: LCM URL of the wire.
        duration: How long [s].

    Raises:
        RemoSplatError: The wire cannot be joined.
    """
    listener = MulticastListener(url)
    heard, end = [], time.monotonic() + duration
    with contextlib.closing(listener):
        while time.monotonic() < end:
            time.sleep(_LISTENING_PERIOD)
            heard += listener.fetch()
    return heard


def check_publishers(
    packets: Sequence[Packet], config: HardwareConfig, has_base: bool
) -> list[Finding]:
    """Finds the senders of statuses, and programs that command already.

    Args:
        packets: The received packets.
        config: Names of the channels.
        has_base: Whether the robot has a mobile base.
    """
    names = config.channels
    wanted = {names.arm_status: 1, names.arm_command: 0}
    if has_base:
        wanted |= {names.base_status: 1, names.base_command: 0}
    senders = collections.defaultdict(set)
    for packet in packets:
        senders[packet.channel].add(packet.sender)
    return [
        judged(
            f"senders of {channel}",
            len(senders[channel]) == count,
            found=_addresses(senders[channel]),
            wanted="one driver" if count else "none yet",
            source="senders' addresses of UDP packets",
            mend=_publisher_advice(channel, count, len(senders[channel])),
        )
        for channel, count in wanted.items()
    ]


def _addresses(senders: set[str]) -> str:
    return ", ".join(sorted(senders)) or "none"


def _publisher_advice(channel: str, wanted: int, found: int) -> str:
    if found < wanted:
        return "start the driver, with this LCM URL"
    if wanted:
        return f"end all but one of the programs that send {channel}"
    return "end the other controller, or take another port in the LCM URL"


def check_reach(packets: Sequence[Packet], config: HardwareConfig) -> Finding:
    """Looks whether our commands get as far as the drivers.

    Args:
        packets: The received packets.
        config: The wire's URL and channels.
    """
    match = re.search(r"ttl=(\d+)", config.url)
    ttl = int(match[1]) if match else 1
    names = config.channels
    drivers = {
        packet.sender.partition(":")[0]
        for packet in packets
        if packet.channel in (names.arm_status, names.base_status)
    }
    elsewhere = sorted(host for host in drivers if not _is_ours(host))
    return judged(
        "reach",
        not elsewhere or ttl > 0,
        found=f"ttl={ttl}; drivers "
        + (f"at {', '.join(elsewhere)}" if elsewhere else "on this computer"),
        wanted="ttl=1 where a driver is on another computer",
        source="the LCM URL, and senders' addresses",
        mend="put ?ttl=1 behind the LCM URL of every process",
    )


def _is_ours(host: str) -> bool:
    """Whether an address is one of this computer: only then it can be bound."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind((host, 0))
        except OSError:
            return False
    return True


@dc.dataclass(frozen=True)
class _Source:
    """Statuses of one part of the robot.

    Attributes:
        part: Name of the part.
        channel: Its channel.
        rate: Least rate [Hz].
        ages: Times of arrival minus stamps [s].
        problem: Faults of the latest broken one.
        modes: The latest mode.
    """

    part: str
    channel: str
    rate: float
    ages: list[float]
    problem: str
    modes: set[str]


def check_statuses(
    packets: Sequence[Packet],
    config: HardwareConfig,
    n_arm: int,
    has_base: bool,
    duration: float = LISTENING,
) -> list[Finding]:
    """Looks how often statuses come, by which clock, and in which mode.

    Args:
        packets: The received packets.
        config: Names of the channels.
        n_arm: Number of the arm's joints.
        has_base: Whether the robot has a mobile base.
        duration: How long it was listened [s].
    """
    names = config.channels

    def arm(data: bytes):
        state = decode_panda_status(data, n_arm)
        return state.stamp, panda_wire.MODE_NAMES[state.robot_mode]

    def base(data: bytes):
        state = decode_base_status(data)
        if state.emergency_stop:
            return state.stamp, "emergency stop"
        if state.protective_stop:
            return state.stamp, "protective stop"
        return state.stamp, base_wire.MODE_NAMES[state.mode]

    arm_rate = min(ARM_RATE, ARM_SHARE * config.arm_status_rate)
    findings = _status_findings(
        _source("arm", names.arm_status, arm_rate, packets, arm), duration
    )
    if has_base:
        findings += _status_findings(
            _source("base", names.base_status, BASE_RATE, packets, base),
            duration,
        )
    return findings


def _source(
    part: str, channel: str, rate: float, packets: Sequence[Packet], read
) -> _Source:
    ages, problem, modes = [], "", set()
    for packet in packets:
        if packet.channel != channel:
            continue
        try:
            stamp, mode = read(packet.data)
        except BrokenMessage as error:
            problem = str(error)
            continue
        ages.append(packet.received - stamp)
        modes = {mode}
    return _Source(part, channel, rate, ages, problem, modes)


def _status_findings(source: _Source, duration: float) -> list[Finding]:
    part, channel, count = source.part, source.channel, len(source.ages)
    rate = count / duration
    findings = [
        judged(
            f"statuses of the {part}",
            rate >= source.rate and not source.problem,
            found=source.problem or f"{rate:.0f} Hz",
            wanted=f"{source.rate:.0f} Hz or more, all whole",
            source=channel,
            mend="look at the driver's log, the cable, and the load of both"
            " computers",
        )
    ]
    if not count:
        return [
            *findings,
            Finding(f"clock of the {part}", SKIPPED, "silent", "", channel),
            Finding(f"mode of the {part}", SKIPPED, "silent", "", channel),
        ]
    age = statistics.median(source.ages)
    mode = ", ".join(source.modes)
    return [
        *findings,
        judged(
            f"clock of the {part}",
            abs(age) <= STAMP_ERROR,
            found=f"statuses are {1e3 * age:.1f} ms old (median)",
            wanted=f"0 to {1e3 * STAMP_ERROR:.0f} ms",
            source=f"stamps in {channel}, and our clock",
            mend="let both computers follow one clock (chrony or PTP)",
        ),
        judged(
            f"mode of the {part}",
            mode in _COMMANDED[part],
            found=mode,
            wanted=" or ".join(_COMMANDED[part]),
            source=channel,
            mend="release the stops; a drake-franka-driver that met a reflex"
            " has ended: start it again",
            otherwise=FAILED,
        ),
    ]
