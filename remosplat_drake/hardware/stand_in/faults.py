"""Faults of a robot, injected on a schedule or on request.

A fault is written NAME[=VALUE]@START[+DURATION], for example `status-stops@3`
or `clock-jump=-0.5@2+1`. START is the time since the first command that the
robot receives [s]. Without a duration, a fault does not end.
"""

import dataclasses as dc
import math
import re
from collections.abc import Sequence

from drake import lcmt_drake_signal, lcmt_panda_status

from remosplat_drake.base.errors import FieldError, unknown_name
from remosplat_drake.hardware.wire.packets import BrokenMessage, decode

CHANNEL = "HARDWARE_SIM_FAULT"
"""Channel of lcmt_drake_signal messages with the names and values of faults
that begin now. The name `recover` ends all faults and releases every stop."""

RECOVER = "recover"
"""Name of the request that ends every fault."""

FAULTS = {
    "status-stops": "the arm sends no statuses, and continues to move",
    "status-delay": "the arm's statuses come VALUE seconds late (default 0.1)",
    "status-freezes": "the arm's statuses repeat the last one, with new stamps",
    "status-nan": "one joint position of the arm's statuses is not a number",
    "status-joints": "the arm's statuses have VALUE joints (default 6)",
    "clock-jump": "the robot's wall clock is VALUE seconds ahead (default 1)",
    "packet-loss": "a fraction VALUE of packets is lost (default 0.5)",
    "reflex": "the arm stops by a reflex until `recover`",
    "user-stop": "the arm's user stop is pressed until `recover`",
    "base-status-stops": "the base sends no statuses, and continues to move",
    "base-protective-stop": "the base has a protective stop for 2 s",
    "base-emergency-stop": "the base has an emergency stop until `recover`",
    "base-command-delay": "the base follows VALUE seconds late (default 0.15)",
    "base-status-delay": "the base's statuses come VALUE seconds late"
    " (default 0.05)",
    "panda-py": "the arm lags as with panda-py's IntegratedVelocity",
    "base-mute": "the base's statuses report no stops, like ROS odometry",
    "base-clock": "the base's stamps are VALUE seconds ahead (default -0.2)",
    "base-jump": "the base's odometry jumps by VALUE metres (default 0.3)",
    "base-drift": "the base's odometry drifts by VALUE m/s (default 0.02)",
    "hand-status-stops": "the hand sends no statuses, and continues to move",
    "hand-opens": "the hand opens, against its command",
    "localization-stops": "the base's localisation sends no messages",
    "localization-frame": "the base's localisation uses another frame",
    "localization-jump": "the base's localisation jumps by VALUE metres"
    " (default 0.3)",
    "localization-drift": "the base's localisation drifts by VALUE m/s"
    " (default 0.02)",
    RECOVER: "ends every fault and releases every stop",
}
"""Names of all faults, and descriptions of their effects for `--help`."""

_DEFAULTS = {
    "status-delay": 0.1,
    "status-joints": 6.0,
    "clock-jump": 1.0,
    "packet-loss": 0.5,
    "base-command-delay": 0.15,
    "base-status-delay": 0.05,
    "base-clock": -0.2,
    "base-jump": 0.3,
    "base-drift": 0.02,
    "localization-jump": 0.3,
    "localization-drift": 0.02,
}

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_PATTERN = re.compile(
    rf"([a-z-]+)(?:=({_NUMBER}))?@(\d+\.?\d*)(?:\+(\d+\.?\d*))?"
)


@dc.dataclass(frozen=True)
class Fault:
    """A fault of the simulated robot, with its beginning and end.

    Attributes:
        name: A key of `FAULTS`.
        value: Size of the fault, in the unit in `FAULTS`; 0 if it has none.
        start: Time of its beginning, after the robot's first command [s].
        end: Time of its end, after the robot's first command [s]; infinite if
            it does not end.
    """

    name: str
    value: float
    start: float = 0.0
    end: float = math.inf


def parse_fault(text: str) -> Fault:
    """Parses a fault of the form NAME[=VALUE]@START[+DURATION].

    Raises:
        FieldError: The text has another form, or the name is not a fault.
    """
    match = _PATTERN.fullmatch(text)
    if match is None:
        raise FieldError(
            "--fault", text, "expected NAME[=VALUE]@START[+DURATION]"
        )
    name, value, start, duration = match.groups()
    if name not in FAULTS:
        raise FieldError("--fault", text, unknown_name("fault", name, FAULTS))
    return Fault(
        name,
        float(value) if value else _DEFAULTS.get(name, 0.0),
        float(start),
        float(start) + float(duration) if duration else math.inf,
    )


def encode_request(name: str, value: float = 0.0) -> bytes:
    """Returns the message on `CHANNEL` that begins a fault.

    Args:
        name: A key of `FAULTS`.
        value: Size of the fault; 0 stands for its default.
    """
    message = lcmt_drake_signal()
    message.dim, message.coord, message.val = 1, [name], [value]
    return message.encode()


def requested_faults(data: bytes) -> list[Fault]:
    """Decodes the faults in a message on `CHANNEL`.

    Unknown names are ignored; a malformed message contains no faults.
    """
    try:
        message = decode(lcmt_drake_signal, data)
    except BrokenMessage:
        return []
    return [
        Fault(name, value or _DEFAULTS.get(name, 0.0))
        for name, value in zip(message.coord, message.val, strict=False)
        if name in FAULTS
    ]


class FaultSchedule:
    """The scheduled faults of a run, and the present ones."""

    def __init__(self, faults: Sequence[Fault] = ()):
        """Starts before any fault.

        Args:
            faults: The scheduled faults.
        """
        self._waiting = sorted(faults, key=lambda fault: fault.start)
        self._active: dict[str, Fault] = {}

    def begin(self, fault: Fault) -> None:
        """Begins a fault now; `recover` ends all faults."""
        if fault.name == RECOVER:
            self._active.clear()
        else:
            self._active[fault.name] = fault

    def advance(self, t: float) -> list[Fault]:
        """Begins and ends faults according to their schedule.

        Args:
            t: Time since the robot's first command [s].

        Returns:
            The faults that begin now.
        """
        begun = [fault for fault in self._waiting if fault.start <= t]
        del self._waiting[: len(begun)]
        for fault in begun:
            self.begin(fault)
        for fault in [f for f in self._active.values() if f.end <= t]:
            del self._active[fault.name]
        return begun

    def __contains__(self, name: str) -> bool:
        return name in self._active

    def value(self, name: str, otherwise: float) -> float:
        """Returns a fault's value, or `otherwise` if it is absent."""
        fault = self._active.get(name)
        return otherwise if fault is None else fault.value


def spoil(status: lcmt_panda_status, faults: FaultSchedule) -> None:
    """Changes a status of the arm by the present faults, in place."""
    if "status-nan" in faults:
        status.joint_position = [math.nan, *status.joint_position[1:]]
    if "status-joints" in faults:
        _resize(status, max(round(faults.value("status-joints", 0.0)), 0))


def _resize(status: lcmt_panda_status, n: int) -> None:
    for name in status.__slots__:
        if name.startswith("joint_"):
            values = list(getattr(status, name))[:n]
            setattr(status, name, values + [0.0] * (n - len(values)))
    status.num_joints = n
