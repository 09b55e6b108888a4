"""Checks the LCM network: its senders, their rates and their clocks."""

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
"""Channel on which the doctor sends test packets to itself; no other program
uses it.
"""

LISTENING = 2.0
"""Messages are received for this time [s]."""

_LISTENING_PERIOD = 1e-3

ARM_RATE, BASE_RATE = 200.0, 9.0
"""Arm and base must send statuses at least at these rates [Hz]. A real Panda
sends at 1 kHz."""

ARM_SHARE = 0.8
"""If the configured rate is less than `ARM_RATE`, at least this fraction of the
arm's statuses must arrive."""

STAMP_ERROR = 0.02
"""When a status arrives, its stamp may differ from our clock by at most this
time [s]."""

_COMMANDED = {"arm": ("idle", "move"), "base": ("ready", "moving")}
"""Modes in which the parts of a robot follow commands."""


def check_loopback(url: str) -> Finding:
    """Checks that multicast packets return to this computer.

    Args:
        url: LCM URL of the robot.
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
        remedy="run `ip link set lo multicast on` and `ip route add 224.0.0.0/4"
        " dev lo`, with the robot's network device in place of lo if needed",
    )


def hear_wire(url: str, duration: float = LISTENING) -> list[Packet]:
    """Receives all messages of an LCM network, except for images.

    Args:
        url: LCM URL of the robot.
        duration: Duration of reception [s].

    Raises:
        RemoSplatError: The multicast group cannot be joined.
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
    """Checks that each status channel has one sender, and commands have none.

    Args:
        packets: The received packets.
        config: Settings, with the names of the channels.
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
            remedy=_publisher_advice(channel, count, len(senders[channel])),
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
    return "end the other controller, or use another port in the LCM URL"


def check_reach(packets: Sequence[Packet], config: HardwareConfig) -> Finding:
    """Checks that commands of this computer reach the drivers' computers.

    Args:
        packets: The received packets.
        config: Settings, with the LCM URL and the channels.
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
        wanted="ttl=1 if a driver is on another computer",
        source="the LCM URL, and senders' addresses",
        remedy="append ?ttl=1 to the LCM URL of every process",
    )


def _is_ours(host: str) -> bool:
    """Whether an address belongs to this computer, so that it can be bound."""
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
        channel: Channel of the statuses.
        rate: Least permitted rate of the statuses [Hz].
        ages: Times of arrival minus stamps [s].
        problem: Faults of the latest malformed status.
        modes: The mode in the latest status, by name.
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
    """Checks the rate, the clock and the mode of statuses.

    Args:
        packets: The received packets.
        config: Settings, with the names of the channels.
        n_arm: Number of the arm's joints.
        has_base: Whether the robot has a mobile base.
        duration: Duration of reception [s].
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
            wanted=f"{source.rate:.0f} Hz or more, all valid",
            source=channel,
            remedy="check the driver's log, the cable, and the load of both"
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
            remedy="synchronise both computers' clocks (chrony or PTP)",
        ),
        judged(
            f"mode of the {part}",
            mode in _COMMANDED[part],
            found=mode,
            wanted=" or ".join(_COMMANDED[part]),
            source=channel,
            remedy="release the stops; restart drake-franka-driver if it has"
            " ended, as it does after a reflex",
            otherwise=FAILED,
        ),
    ]
