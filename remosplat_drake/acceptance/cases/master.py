"""Faults: another program commands the robot, or sends its statuses."""

from remosplat_drake.acceptance.fault_case import (
    GOES_ON,
    MOVES,
    FaultCase,
    Part,
)
from remosplat_drake.acceptance.stranger import (
    ARM,
    BASE,
    COMMANDS,
    GARBAGE,
    STRANGERS,
)

_TOUR = "time_limit: 600\ntargets:" + 20 * (
    "\n- {translation: [1.15, 0.0, 0.66], rpy_deg: [180, 0, 0]}"
    "\n- {translation: [0.95, 0.45, 0.95], rpy_deg: [180, 0, 0]}"
)
"""A low and a high target, repeated twenty times. The motion to them takes
longer than another process needs to start.
"""


def _stranger(name: str, what: str, reason: str) -> FaultCase:
    assert what in STRANGERS
    return FaultCase(
        name,
        Part.STRANGER,
        what,
        reason=reason,
        refusal=reason,
        resumes=MOVES,
        text=_TOUR,
    )


CASES = (
    FaultCase(
        "second controller",
        Part.SECOND_CONTROLLER,
        outcome=GOES_ON,
        text=_TOUR,
    ),
    FaultCase(
        "second robot",
        Part.SECOND_ROBOT,
        reason="has two senders",
        refusal="has two senders",
        resumes=MOVES,
        text=_TOUR,
    ),
    _stranger("commands of another program", COMMANDS, "also sends commands"),
    _stranger(
        "statuses of the arm from another program",
        ARM,
        "PANDA_STATUS: has two senders",
    ),
    _stranger(
        "statuses of the base from another program",
        BASE,
        "BASE_STATUS: has two senders",
    ),
    _stranger("garbage on every channel", GARBAGE, "also sends commands"),
)
