"""The interface of systems that output targets."""

from typing import Any, Protocol

from pydrake.systems.framework import (
    Context,
    InputPort,
    OutputPort,
    System,
)

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.task.arrival import ArrivalConfig
from remosplat_drake.task.target_sequence import TargetProgress

PORTS = ("configuration",), ("target",)
"""Names of the input and the output ports of targets: the measured q, shape
(n_q,), and the target pose X_WT, a `RigidTransform`."""

AIM = "aim"
"""Name of an optional output port with an `Aim` or a `Target`, for targets with
more options than a pose; it replaces `target`."""


class Targets(Protocol):
    """A system that outputs targets of the end effector.

    `TargetSequence` implements this interface. Another implementation is any
    `LeafSystem` with the ports `PORTS` and the methods `progress` and `error`.
    The port `AIM` is optional. No output may depend on the controller's output
    in the same tick.
    """

    def progress(self, context: Context) -> TargetProgress:
        """Returns the progress; the run ends when it is finished.

        Args:
            context: The context of this system.
        """
        ...

    def error(self, context: Context) -> PoseError:
        """Returns the pose error from the end effector to the present target.

        Args:
            context: The context of this system.
        """
        ...

    def GetInputPort(self, port_name: str) -> InputPort:
        """Finds an input port by its name, as every Drake system does."""
        ...

    def GetOutputPort(self, port_name: str) -> OutputPort:
        """Finds an output port by its name, as every Drake system does."""
        ...

    def HasOutputPort(self, port_name: str) -> bool:
        """Returns whether there is such a port, as every Drake system does."""
        ...

    def GetMyContextFromRoot(self, root_context: Context) -> Context:
        """Finds the context of this system, as every Drake system does."""
        ...


class TargetsMaker(Protocol):
    """The interface of settings that make a system of targets."""

    def make(
        self, robot: RobotModel, arrival: ArrivalConfig, period: float
    ) -> Targets:
        """Makes the system that outputs the targets.

        Args:
            robot: The robot.
            arrival: The scenario's rule of arrival.
            period: The control period [s].
        """
        ...


def target_port(targets: Targets) -> OutputPort:
    """Returns the port `aim` of a system of targets, or else `target`.

    Args:
        targets: The system.
    """
    is_full = targets.HasOutputPort(AIM)
    return targets.GetOutputPort(AIM if is_full else "target")


def check_targets(targets: Any, name: str) -> None:
    """Raises an error if a system cannot output targets.

    Args:
        targets: The system.
        name: Name of the system in errors.

    Raises:
        RemoSplatError: The system lacks a port or a method.
    """
    if not isinstance(targets, System):
        raise RemoSplatError(f"targets: {name}: expected a Drake system")
    missing = [
        f"the method {method}"
        for method in ("progress", "error")
        if not callable(getattr(targets, method, None))
    ]
    inputs, outputs = PORTS
    missing += [f"the input {n}" for n in inputs if not targets.HasInputPort(n)]
    missing += [
        f"the output {n}" for n in outputs if not targets.HasOutputPort(n)
    ]
    if missing:
        raise RemoSplatError(f"targets: {name} lacks {', '.join(missing)}")
