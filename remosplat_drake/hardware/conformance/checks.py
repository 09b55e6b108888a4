"""Checks the messages of a robot: a finding for each rule of the wire."""

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
    PartRecord,
    RobotRecord,
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
"""Least share of the configured rate at which statuses come."""

_AHEAD = 0.002
"""How far a stamp may be ahead of our clock [s]."""

_SAME = 0.15
"""By which share a gain of an axis may differ from 1."""

_OTHER = 0.1
"""Greatest gain of an axis by the commands of another one."""

_VELOCITY = 0.3
"""Permitted deviation of the ratio of the velocities from 1."""

_RESOLUTION = 0.005
"""Resolution of delays [s]."""

_MODE_WORDS = (
    "a mode in which the part moves, and another one while it is stopped"
)


def judge(
    record: RobotRecord, config: HardwareConfig, actuators: Sequence[Actuator]
) -> list[Finding]:
    """Evaluates a record; see `Seen` for its required content.

    Args:
        record: The received messages.
        config: Rates and limits of the controller.
        actuators: How the axes should follow, base first.
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
    """The observations so far that a record must contain."""

    def __init__(self):
        """Starts with nothing."""
        self._axes: dict[str, dict[str, _Range]] = {}
        self._stopped: dict[str, bool] = {}
        self._drivers: set[int] = set()

    def add(self, record: RobotRecord) -> None:
        """Adds the messages since then."""
        for part in record.parts:
            axes = self._axes.setdefault(part.part, {})
            ways = commanded_ways(part)
            for axis, way in zip(part.axes, ways.T, strict=True):
                axes.setdefault(axis, _Range()).add(way)
            stopped = bool(set(part.modes) - part.obeys)
            before = self._stopped.get(part.part, False)
            self._stopped[part.part] = before or stopped
        self._drivers |= record.drivers.keys()

    def missing(self, stop: bool, restart: bool) -> list[str]:
        """Names the missing observations, in words for an operator.

        Args:
            stop: Whether stops are waited for.
            restart: Whether a restart of a driver is.
        """
        found = []
        for part, axes in self._axes.items():
            still = [a for a, way in axes.items() if way.width <= MOVED]
            if still:
                found.append(f"motion of {', '.join(still)}")
            if stop and not self._stopped[part]:
                found.append(f"a stop of the {part}")
        if restart and len(self._drivers) <= len(self._axes):
            found.append("a restart of a driver")
        return found


@dc.dataclass
class _Range:
    """The range of a way [rad, m] that is continued piece by piece."""

    end: float = 0.0
    low: float = 0.0
    high: float = 0.0

    def add(self, piece: np.ndarray) -> None:
        """Continues the way by a piece, which starts at 0; shape (c,)."""
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
        "start the driver with this LCM URL, and read what it says",
    )


def _whole(part: PartRecord) -> Finding:
    count = sum(part.broken.values())
    return judged(
        f"{part.part}: whole",
        not count,
        found=f"{count} broken: {next(iter(part.broken))}"
        if count
        else f"{len(part.stamp)} statuses, all whole",
        wanted="finite positions and velocities of every axis",
        source=part.channel,
        mend="send no status rather than one with a number that is not known",
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
        mend="say the rate in hardware.arm_status_rate, or raise the robot's",
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
        wanted=f"0 to {1e3 * STAMP_ERROR:.0f} ms when they come",
        source=f"stamps of {part.channel}, and our clock",
        mend="carry the stamp of the source through; let both computers follow"
        " one clock; look for queues on the way",
    )


def _gaps(part: PartRecord, config: HardwareConfig) -> Finding:
    limit = config.base_status_expiry
    if part.part == "arm":
        limit = config.arm_status_limit
    # A message that comes late is as bad as one that does not come.
    longest = float(np.diff(part.received, prepend=part.received[0]).max())
    return judged(
        f"{part.part}: silence",
        longest <= limit,
        found=f"at most {1e3 * longest:.0f} ms",
        wanted=f"at most {1e3 * limit:.0f} ms, after which the robot is"
        " stopped",
        source=f"arrivals on {part.channel}",
        mend="raise the driver's priority; run nothing else on its computer; a"
        " restart of the driver causes silence, too",
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
        mend="let the driver read the robot's stop: `emergency_stop` and"
        " `mode` of !Ros2Arm name topics",
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
            mend="look at the driver's order of axes, signs and units",
        )
        yield judged(
            f"{name}: velocity",
            abs(velocity - 1.0) <= _VELOCITY,
            found=f"{velocity:.2f} times the change of position per time",
            wanted=f"{1 - _VELOCITY:.1f} to {1 + _VELOCITY:.1f}",
            source=part.channel,
            mend="let the source report velocities, or the driver compute them",
        )
        tube = actuators[i].tube + _RESOLUTION
        late = following.late[i]
        told = actuators[i].delay + actuators[i].time_constant
        yield judged(
            f"{name}: latency",
            bool(late <= tube) and gain != 0.0,
            found=f"{1e3 * (late + told):.0f} ms",
            wanted=f"at most {1e3 * (told + tube):.0f} ms, as described",
            source="commands and stamps",
            mend="measure it with `remosplat identify`; if it is long, look at"
            " driver and network",
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
        return f"moves by {row[strongest]:.2f} of {axes[strongest]}'s commands"
    return f"moves by {row[axis]:.2f} of its commands"


def _restart(record: RobotRecord) -> Finding:
    check, source = "restart", "DRIVER_REPORT"
    wanted = "a driver that ends and comes back under a name of its own"
    if len(record.drivers) <= len(record.parts):
        return Finding(check, SKIPPED, "not seen", wanted, source)
    names = ", ".join(sorted(set(record.drivers.values())))
    return judged(
        check,
        True,
        found=f"{len(record.drivers)} sessions of {names}",
        wanted=wanted,
        source=source,
        mend="",
    )
