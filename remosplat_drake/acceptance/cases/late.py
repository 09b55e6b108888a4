"""Faults: robots with delays, some of which their descriptions contain.

A robot whose delays have been identified keeps its clearance with any delay. A
robot whose delays have not been identified is stopped if they exceed the
default bounds.
"""

import dataclasses as dc
from collections.abc import Iterator

from remosplat_drake.acceptance.cases.target import THROUGH_THE_TABLE
from remosplat_drake.acceptance.fault_case import (
    GOES_ON,
    MISMATCH,
    FaultCase,
    Part,
    controller_fault,
    robot_fault,
)
from remosplat_drake.robot.actuators import Actuator, panda_py_actuators
from remosplat_drake.safety.supervisor_system import STOP_BUTTON

_LEAST = 0.015
"""With a stopping distance of 21 mm, the true clearance must be at least this
distance [m]."""

_BASE = Actuator(tube=0.01, noise=0.02)
_ARM = Actuator(delay=0.005, tube=0.01, noise=0.003)
"""Actuator model with approximately the bounds that `remosplat identify` finds,
except for the delay."""


def _base(delay: float) -> list[Actuator]:
    return [dc.replace(_BASE, delay=delay)] * 2 + [_ARM] * 7


def _panda_py() -> list[Actuator]:
    known = {"tube": _ARM.tube, "noise": _ARM.noise}
    arm = [dc.replace(joint, **known) for joint in panda_py_actuators()]
    return [_BASE] * 2 + arm


def _identified(
    name: str, actuators: list[Actuator], *faults: str
) -> Iterator[FaultCase]:
    """Makes cases of a robot with identified delays.

    In one case, an operator stops the robot. In the other one, the target is
    below the table top.
    """
    known = {
        "robot": tuple(x for fault in faults for x in ("--fault", fault)),
        "actuators": tuple(actuators),
        "clearance": _LEAST,
    }
    yield controller_fault(
        f"stop button, {name}", "stop-button", STOP_BUTTON, **known
    )
    yield FaultCase(
        f"target through the table, {name}",
        Part.TARGET,
        outcome=GOES_ON,
        watch=6.0,
        text=THROUGH_THE_TABLE,
        **known,
    )


def _unmeasured(name: str, fault: str, **more) -> FaultCase:
    """Makes a case of a robot whose delays exceed the default bounds.

    No refusal of a release is expected, since a robot at rest shows no delay.
    """
    return robot_fault(
        f"{name}, unmeasured",
        fault,
        MISMATCH,
        refusal=None,
        watch=2.0,
        **more,
    )


CASES = (
    *_identified(
        "base 150 ms late, statuses 50 ms",
        _base(0.15),
        "base-command-delay=0.15@0",
        "base-status-delay=0.05@0",
    ),
    *_identified(
        "base 250 ms late, statuses 100 ms",
        _base(0.25),
        "base-command-delay=0.25@0",
        "base-status-delay=0.1@0",
    ),
    *_identified("arm under panda-py's law", _panda_py(), "panda-py@0"),
    _unmeasured(
        "base 250 ms late",
        "base-command-delay",
        value=0.25,
        then="base-status-delay",
    ),
    _unmeasured("arm under panda-py's law", "panda-py"),
)
