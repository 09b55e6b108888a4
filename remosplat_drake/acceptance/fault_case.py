"""`FaultCase`: a fault in a run, and its required outcome."""

import dataclasses as dc
from enum import Enum
from typing import Any

from remosplat_drake.hardware.stand_in import faults
from remosplat_drake.robot.actuators import Actuator


class Part(Enum):
    """The part of the system in which a fault occurs."""

    ROBOT = "robot"
    """`remosplat hardware-sim`, with a fault that is requested over the
    network."""
    CONTROLLER = "controller"
    """`fault_controller`, with a fault that begins at a signal."""
    NETWORK = "network"
    """The relay on the network, which delays and loses messages."""
    TARGET = "target"
    """The target in the scenario, which jumps."""
    DRIVER_KILLED = "driver killed"
    """The robot's process, which is killed and started again."""
    ARM_DRIVER_STALLED = "arm driver stalled"
    """`remosplat panda-driver`, which is stopped (SIGSTOP)."""
    ARM_CALLBACK_STALLED = "arm callback stalled"
    """The arm driver's process for the 1 kHz callback, which is stopped
    (SIGSTOP)."""
    SECOND_ROBOT = "second robot"
    """A second `remosplat hardware-sim`, which joins the network."""
    SECOND_CONTROLLER = "second controller"
    """A second `remosplat run --hardware`, which tries to drive the robot."""
    STRANGER = "stranger"
    """A process of `stranger`, which joins the network."""
    CONTROLLER_KILLED = "controller killed"
    """The controller's process, which is killed."""
    INTERRUPT = "interrupt"
    """The controller's process, which receives Ctrl-C."""


STOPS = "stops"
"""Outcome: the supervisor stops the robot until an operator releases the
stop."""
DRIVER_STOPS = "the drivers stop"
"""Outcome: the command expires in the drivers. No process remains that could
report a reason.
"""
ENDS = "ends"
"""Outcome: the program brings the robot to rest, and ends."""
JOINING = (Part.SECOND_ROBOT, Part.SECOND_CONTROLLER, Part.STRANGER)
"""Parts that are additional processes on the network."""

GOES_ON = "goes on"
"""Outcome: the robot may continue. It must keep its clearance, and either reach
its target or stop.
"""

REACHES = "reaches the target"
"""Behaviour after a release: the robot continues to its target."""
MOVES = "moves"
"""Behaviour after a release: the robot moves, but its target is unreachable."""
STAYS = ""
"""Behaviour after a release: the robot stays at rest, since the fault persists
until a restart.
"""


MISMATCH = ("does not move as", "deviates from its actuator model")
"""Texts of the two checks that compare a robot's motion with its commands. If
both apply, either may be the first."""


@dc.dataclass(frozen=True)
class FaultCase:
    """One fault, injected while the robot moves, and the expected reaction.

    Attributes:
        name: Name of the case in tables.
        part: Part of the system in which the fault occurs.
        fault: Name of the fault, if the part has several.
        value: Magnitude of the fault, in the unit of the fault.
        outcome: Expected outcome: STOPS, DRIVER_STOPS, ENDS or GOES_ON.
        reason: Text that the reason of the stop must contain, or several texts
            of which it must contain one.
        refusal: Text that the answer to a release must contain while the fault
            is present; None if no release is tried.
        resumes: Expected resumption, REACHES, MOVES or STAYS, once the fault is
            gone and the stop released; None if any is permitted.
        then: Name of a second fault, which follows the first one; empty if
            there is none.
        tick_status: Status that at least one tick must have, which shows that
            the fault had an effect; empty if any status is valid.
        watch: Time to observe the robot after the fault is over [s].
        text: YAML that overrides fields of the scenario.
        robot: Further arguments of `remosplat hardware-sim`.
        delay: Delay of the network [s].
        loss: Fraction of messages that the network loses, in [0, 1].
        arm_driver: Whether `remosplat panda-driver` drives the arm; it is
            restarted when the fault is over.
        ros2: Whether the robot is on ROS 2, and `arm-driver` and `base-driver`
            connect it to the network.
        actuators: Actuator models in the controller's robot description; empty
            if they have not been identified.
        clearance: True clearance that the robot must keep [m].
    """

    name: str
    part: Part
    fault: str = ""
    value: float = 0.0
    outcome: str = STOPS
    reason: str | tuple[str, ...] = ""
    refusal: str | None = None
    resumes: str | None = REACHES
    then: str = ""
    tick_status: str = ""
    watch: float = 1.0
    text: str = ""
    robot: tuple[str, ...] = ()
    delay: float = 0.0
    loss: float = 0.0
    arm_driver: bool = False
    ros2: bool = False
    actuators: tuple[Actuator, ...] = ()
    clearance: float = 0.0

    def expects(self, reason: str) -> bool:
        """Returns whether a stop for a reason is an expected reaction."""
        texts = (self.reason,) if isinstance(self.reason, str) else self.reason
        return any(text in reason for text in texts)


def robot_fault(
    name: str, fault: str, reason: str | tuple[str, ...], **more
) -> FaultCase:
    """Makes a case with a fault of `remosplat hardware-sim`.

    The reason of the stop and the refusal of a release contain the same text.

    Args:
        name: Name of the case in tables.
        fault: A key of `faults.FAULTS`.
        reason: Text that the reason and the refusal must contain. If there are
            several, `refusal` must be given, too.
        more: Further fields of the case.
    """
    assert fault in faults.FAULTS
    fields: dict[str, Any] = {"reason": reason, "refusal": reason} | more
    return FaultCase(name, Part.ROBOT, fault, **fields)


def controller_fault(name: str, fault: str, reason: str, **more) -> FaultCase:
    """Makes a case with a fault of `fault_controller`.

    Args:
        name: Name of the case in tables.
        fault: Name of the fault in `fault_controller.FAULTS`.
        reason: Text that the reason must contain.
        more: Further fields of the case.
    """
    return FaultCase(name, Part.CONTROLLER, fault, reason=reason, **more)
