"""What goes wrong in the fault campaign, and what shall come of it."""

import dataclasses as dc
from enum import Enum

from remosplat_drake.hardware.stand_in import faults
from remosplat_drake.safety.supervisor_system import STOP_BUTTON
from remosplat_drake.signals.tick_report import BRAKING, RELAXED


class Part(Enum):
    """The part of the system in which something goes wrong."""

    ROBOT = "robot"
    """A fault of `remosplat hardware-sim`, told over the wire."""
    CONTROLLER = "controller"
    """A fault of `fault_controller`, begun by a signal."""
    NETWORK = "network"
    """The relay between the two turns bad."""
    TARGET = "target"
    """The scenario's own target jumps."""
    DRIVER_KILLED = "driver killed"
    """The robot's process is killed, and started again."""
    CONTROLLER_KILLED = "controller killed"
    """The controller's process is killed."""
    INTERRUPT = "interrupt"
    """The controller gets Ctrl-C."""


STOPS = "stops"
"""Outcome: the supervisor stops the robot, and only a release ends that."""
DRIVER_STOPS = "the drivers stop"
"""Outcome: nobody is left to give a reason; the drivers let the command
expire."""
ENDS = "ends"
"""Outcome: the program brings the robot to rest, and ends."""
GOES_ON = "goes on"
"""Outcome: the robot may go on, is safe, and reaches its target or stands."""

REACHES = "reaches the target"
"""Resumption: after a release the robot goes on to its target."""
MOVES = "moves"
"""Resumption: after a release the robot moves; its target is unreachable."""


@dc.dataclass(frozen=True)
class FaultCase:
    """One fault that is injected while the robot moves, and what must follow.

    Attributes:
        name: Name of the case in tables.
        part: Part of the system in which the fault occurs.
        fault: Name of the fault, where the part has several.
        value: Magnitude of the fault, in its own unit, where it has one.
        outcome: Expected outcome: STOPS, DRIVER_STOPS, ENDS or GOES_ON.
        reason: Text that the reason of the stop must contain.
        refusal: Text that the answer to a release must contain while the fault
            is present; None where no release is tried.
        resumes: Expected resumption, REACHES or MOVES, once the fault is gone
            and the stop released.
        then: Name of another fault that follows at once; empty for none.
        tick_status: Status that some of the controller's ticks must have,
            where it has to notice the fault; empty for any.
        watch: Time to observe the robot after the fault is over [s].
        text: YAML that overrides fields of the scenario.
        delay: Delay of the network [s].
        loss: Share of messages that the network loses, in [0, 1].
    """

    name: str
    part: Part
    fault: str = ""
    value: float = 0.0
    outcome: str = STOPS
    reason: str = ""
    refusal: str | None = None
    resumes: str = REACHES
    then: str = ""
    tick_status: str = ""
    watch: float = 1.0
    text: str = ""
    delay: float = 0.0
    loss: float = 0.0


_THROUGH_THE_TABLE = """
arrival: {position: 0.35, angle: 180}
targets:
- {translation: [1.15, 0.0, 0.66], rpy_deg: [180, 0, 0]}
- {translation: [1.3, 0.0, 0.2], rpy_deg: [180, 0, 0]}
"""
"""The first target counts as reached while the arm is on its way to it; the
second one is below the table top."""


def _robot(name: str, fault: str, reason: str, **more) -> FaultCase:
    assert fault in faults.FAULTS
    return FaultCase(
        name, Part.ROBOT, fault, reason=reason, refusal=reason, **more
    )


def _controller(name: str, fault: str, reason: str, **more) -> FaultCase:
    return FaultCase(name, Part.CONTROLLER, fault, reason=reason, **more)


CASES = (
    _robot("status stops", "status-stops", "nothing came for"),
    _robot("status freezes, stamps fresh", "status-freezes", "frozen for"),
    _robot("NaN in status", "status-nan", "is nan"),
    _robot("6 joints in status", "status-joints", "not 7", value=6.0),
    _robot("clock jumps 1 s ahead", "clock-jump", "stamps jumped", value=1.0),
    _robot("clock jumps 1 s back", "clock-jump", "stamps jumped", value=-1.0),
    _robot("reflex of the arm", "reflex", "reflex"),
    _robot(
        "reflex, then status stops",
        "reflex",
        "reflex",
        then="status-stops",
    ),
    _robot("user stop of the arm", "user-stop", "user_stopped"),
    _robot("base status stops", "base-status-stops", "BASE_STATUS: nothing"),
    _robot(
        "base protective stop, ends by itself",
        "base-protective-stop",
        "protective stop",
        watch=3.0,
    ),
    _robot("emergency stop of the base", "base-emergency-stop", "emergency"),
    _robot(
        "half of the arm's packets lost",
        "packet-loss",
        "commands reach the arm",
        value=0.5,
    ),
    FaultCase(
        "driver killed and restarted",
        Part.DRIVER_KILLED,
        reason="nothing came for",
        refusal="nothing came for",
        watch=2.0,
    ),
    FaultCase(
        "controller killed", Part.CONTROLLER_KILLED, outcome=DRIVER_STOPS
    ),
    _controller("controller hangs", "hang", "", outcome=DRIVER_STOPS),
    _controller("exception in a tick", "exception", "", outcome=ENDS),
    FaultCase("Ctrl-C", Part.INTERRUPT, outcome=ENDS),
    _controller("stop button", "stop-button", STOP_BUTTON),
    # No release is tried in between: such statuses are just as old as they
    # may be, now on this side of the limit and now on that.
    FaultCase(
        "network delay 50 ms, loss 20 %",
        Part.NETWORK,
        delay=0.05,
        loss=0.2,
        reason="PANDA_STATUS",
    ),
    FaultCase("network loss 20 %", Part.NETWORK, loss=0.2, outcome=GOES_ON),
    _controller(
        "stale map",
        "map-age",
        "the map is",
        refusal="the map is",
        text="{supervisor: {max_map_age: 0.5}}",
    ),
    _controller(
        "map unknown (NaN)",
        "map-nan",
        "clearance",
        refusal="clearance",
        tick_status=BRAKING,
    ),
    _controller(
        "QP infeasible for 1.2 s",
        "infeasible",
        "",
        outcome=GOES_ON,
        tick_status=RELAXED,
        watch=2.5,
    ),
    FaultCase(
        "target jumps through the table",
        Part.TARGET,
        outcome=GOES_ON,
        watch=4.0,
        text=_THROUGH_THE_TABLE,
    ),
    FaultCase(
        "the same, jumps limited to 0.2 m",
        Part.TARGET,
        reason="the target jumped",
        resumes=MOVES,
        text=_THROUGH_THE_TABLE + "supervisor: {max_target_jump: 0.2}\n",
    ),
)
"""All cases of the campaign."""
