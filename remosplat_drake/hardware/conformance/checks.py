"""Checks the messages of a robot; makes a `Finding` for each rule."""

import dataclasses as dc
from collections.abc import Iterator, Sequence

import numpy as np

from remosplat_drake.hardware.conformance.following import (
    MOVED,
    Following,
    commanded_ways,
    examine,
)
from remosplat_drake.hardware.conformance.robot_record import (
    DriverSession,
    PartRecord,
    RobotRecord,
    add_session,
    restarted_drivers,
)
from remosplat_drake.hardware.doctor.finding import (
    FAILED,
    SKIPPED,
    Finding,
    judged,
)
from remosplat_drake.hardware.doctor.wire_checks import BASE_RATE, STAMP_ERROR
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.robot.actuators import Actuator

SHARE = 0.8
"""Statuses must have at least this fraction of the configured rate."""

_AHEAD = 0.002
"""A stamp may be ahead of our clock by at most this time [s]."""

_SAME = 0.15
"""Permitted deviation of an axis' gain from 1. The gain is the axis' motion per
commanded motion.
"""

_OTHER = 0.1
"""If one axis is commanded to move, another axis may move by at most this
fraction of the commanded motion."""

_VELOCITY = 0.3
"""The ratio of the reported velocity to the change of position per time may
deviate from 1 by at most this value."""

_RESOLUTION = 0.005
"""Measured delays are multiples of this time [s]."""

_MODE_WORDS = (
    "a mode in which the part moves, and another mode while it is stopped"
)


def judge(
    record: RobotRecord, config: HardwareConfig, actuators: Sequence[Actuator]
) -> list[Finding]:
    """Evaluates a robot's messages; `Seen` checks that they suffice.

    Args:
        record: The received messages.
        config: Settings, with the controller's rates and limits.
        actuators: Actuator models of all axes, those of the base first.
    """
    findings = []
    for part in record.parts:
        base = part.part == "base"
        n = len(part.axes)
        own = actuators[:n] if base else actuators[-n:]
        if not len(part.stamp):
            findings.append(_silent(part))
            continue
        following = examine(part, own)
        findings += [
            _whole(part),
            _rate(part, config, record.duration),
            _age(part),
            _gaps(part, config),
            _mode(part),
            *_axes(part, following, own),
        ]
    findings.append(_restart(record))
    return findings


class Seen:
    """Records which of the required observations have been made."""

    def __init__(self):
        """Starts without observations."""
        self._axes: dict[str, dict[str, _Range]] = {}
        self._stopped: dict[str, bool] = {}
        self._drivers: dict[int, DriverSession] = {}

    def add(self, record: RobotRecord) -> None:
        """Adds the messages of another record."""
        for part in record.parts:
            axes = self._axes.setdefault(part.part, {})
            ways = commanded_ways(part)
            for axis, way in zip(part.axes, ways.T, strict=True):
                axes.setdefault(axis, _Range()).add(way)
            stopped = bool(set(part.modes) - part.obeys)
            before = self._stopped.get(part.part, False)
            self._stopped[part.part] = before or stopped
        for number, session in record.drivers.items():
            add_session(self._drivers, number, session)

    def missing(self, stop: bool, restart: bool) -> list[str]:
        """Lists the missing observations, as texts for an operator.

        Args:
            stop: Whether stops of all parts are required.
            restart: Whether a restart of a driver is required.
        """
        found = []
        for part, axes in self._axes.items():
            still = [a for a, way in axes.items() if way.width <= MOVED]
            if still:
                found.append(f"motion of {', '.join(still)}")
            if stop and not self._stopped[part]:
                found.append(f"a stop of the {part}")
        if restart and not restarted_drivers(self._drivers.values()):
            found.append("a restart of a driver")
        return found


@dc.dataclass
class _Range:
    """The range of an axis' position [rad, m], updated with each record."""

    end: float = 0.0
    low: float = 0.0
    high: float = 0.0

    def add(self, piece: np.ndarray) -> None:
        """Adds c positions, relative to the last one of the previous call."""
        if len(piece):
            self.low = min(self.low, self.end + piece.min())
            self.high = max(self.high, self.end + piece.max())
            self.end += piece[-1]

    @property
    def width(self) -> float:
        return self.high - self.low


def _silent(part: PartRecord) -> Finding:
    problem = next(iter(part.broken), "none came")
    return Finding(
        f"{part.part}: statuses",
        FAILED,
        problem,
        f"statuses on {part.channel}",
        part.channel,
        "start the driver with this LCM URL, and read its messages",
    )


def _whole(part: PartRecord) -> Finding:
    count = sum(part.broken.values())
    return judged(
        f"{part.part}: whole",
        not count,
        found=f"{count} malformed: {next(iter(part.broken))}"
        if count
        else f"{len(part.stamp)} statuses, all valid",
        wanted="finite positions and velocities of every axis",
        source=part.channel,
        remedy="if a number is unknown, let the driver send no status",
    )


def _rate(part: PartRecord, config: HardwareConfig, duration: float) -> Finding:
    wanted = BASE_RATE
    if part.part == "arm":
        wanted = SHARE * config.arm_status_rate
    rate = len(np.unique(part.stamp)) / duration
    return judged(
        f"{part.part}: rate",
        rate >= wanted,
        found=f"{rate:.0f} Hz",
        wanted=f"{wanted:.0f} Hz or more",
        source=f"stamps of {part.channel}",
        remedy="set hardware.arm_status_rate, or raise the robot's rate",
    )


def _age(part: PartRecord) -> Finding:
    age = part.received - part.stamp
    middle, first, last = np.percentile(age, (50, 1, 99))
    good = first >= -_AHEAD and middle <= STAMP_ERROR
    return judged(
        f"{part.part}: age of measurements",
        bool(good),
        found=f"{1e3 * middle:.1f} ms (1 %: {1e3 * first:.1f}, 99 %:"
        f" {1e3 * last:.1f})",
        wanted=f"0 to {1e3 * STAMP_ERROR:.0f} ms on arrival",
        source=f"stamps of {part.channel}, and our clock",
        remedy="let the driver pass on the stamp of the measurement;"
        " synchronise both computers' clocks; look for queues between robot "
        "and controller",
    )


def _gaps(part: PartRecord, config: HardwareConfig) -> Finding:
    limit = config.base_status_expiry
    if part.part == "arm":
        limit = config.arm_status_limit
    # A late message causes the same gap as a lost message.
    longest = float(np.diff(part.received, prepend=part.received[0]).max())
    return judged(
        f"{part.part}: silence",
        longest <= limit,
        found=f"at most {1e3 * longest:.0f} ms",
        wanted=f"at most {1e3 * limit:.0f} ms, after which the robot is"
        " stopped",
        source=f"arrivals on {part.channel}",
        remedy="raise the driver's priority; end other programs on its"
        " computer; a restart of the driver also causes silence",
    )


def _mode(part: PartRecord) -> Finding:
    obeyed = part.obeys.intersection(part.modes)
    stopped = set(part.modes) - part.obeys
    seen = ", ".join(part.modes)
    return judged(
        f"{part.part}: mode and emergency stop",
        bool(obeyed and stopped),
        found=f"{seen} all the time" if len(part.modes) == 1 else seen,
        wanted=_MODE_WORDS,
        source=f"modes of {part.channel}, while a person presses the stop",
        remedy="let the driver report the robot's stops: for !Ros2Arm, set"
        " the topics `emergency_stop` and `mode`",
    )


def _axes(
    part: PartRecord, following: Following, actuators: Sequence[Actuator]
) -> Iterator[Finding]:
    for i, axis in enumerate(part.axes):
        name = f"{part.part}: {axis}"
        if not following.moved[i]:
            yield Finding(
                name,
                SKIPPED,
                "was not moved",
                "a motion",
                part.channel,
                "move it with `remosplat identify` or `remosplat run`",
            )
            continue
        gain, velocity = following.gains[i, i], following.velocity[i]
        yield judged(
            name,
            _is_right(following, i),
            found=_words(following, i, part.axes),
            wanted="motion as commanded, in rad or m, and only of this axis",
            source=f"commands, and positions in {part.channel}",
            remedy="check the driver's order of axes, signs and units",
        )
        yield judged(
            f"{name}: velocity",
            abs(velocity - 1.0) <= _VELOCITY,
            found=f"{velocity:.2f} times the change of position per time",
            wanted=f"{1 - _VELOCITY:.1f} to {1 + _VELOCITY:.1f}",
            source=part.channel,
            remedy="let the robot report velocities, or the driver compute"
            " them",
        )
        tube = actuators[i].tube + _RESOLUTION
        late = following.late[i]
        told = actuators[i].delay + actuators[i].time_constant
        yield judged(
            f"{name}: latency",
            bool(late <= tube) and gain != 0.0,
            found=f"{1e3 * (late + told):.0f} ms",
            wanted=f"at most {1e3 * (told + tube):.0f} ms, according to the"
            " robot's description",
            source="commands and stamps",
            remedy="measure the delay with `remosplat identify`; if it is long,"
            " check driver and network",
        )


def _is_right(following: Following, axis: int) -> bool:
    row = following.gains[axis]
    others = np.delete(row, axis)
    return bool(
        abs(row[axis] - 1.0) <= _SAME
        and np.abs(others).max(initial=0.0) <= _OTHER
    )


def _words(following: Following, axis: int, axes: Sequence[str]) -> str:
    row = following.gains[axis]
    strongest = int(np.abs(row).argmax())
    if strongest != axis and abs(row[strongest]) > _OTHER:
        other = axes[strongest]
        return (
            f"it moves by {row[strongest]:.2f} of the motion commanded to "
            f"{other}"
        )
    return f"moves by {row[axis]:.2f} of the commanded motion"


def _restart(record: RobotRecord) -> Finding:
    check, source = "restart", "DRIVER_REPORT"
    wanted = "a driver that ends and restarts, with a new session"
    names = restarted_drivers(record.drivers.values())
    if not names:
        return Finding(check, SKIPPED, "not seen", wanted, source)
    return judged(
        check,
        True,
        found=f"{', '.join(names)} restarted",
        wanted=wanted,
        source=source,
        remedy="",
    )
