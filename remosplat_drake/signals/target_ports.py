"""Declares and connects the input ports for a system's target."""

import dataclasses as dc

from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    InputPort,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.signals.aim import Aim


@dc.dataclass(frozen=True, eq=False)
class TargetPorts:
    """A system's two input ports for its target, one of which is connected.

    Attributes:
        pose: Port of a plain target, the pose X_WT as a `RigidTransform`.
        full: Port of an `Aim`, or of a `Target` of the first end effector. It
            takes precedence if both ports are connected.
    """

    pose: InputPort
    full: InputPort

    @staticmethod
    def declare(system: LeafSystem) -> "TargetPorts":
        """Declares the inputs `target` and `aim`.

        Args:
            system: The system, which is being constructed.
        """
        return TargetPorts(
            system.DeclareAbstractInputPort("target", Value(RigidTransform())),
            system.DeclareAbstractInputPort("aim", Value[object]()),
        )

    def read(self, context: Context) -> Aim:
        """Returns the current aim.

        Args:
            context: The system's own context.
        """
        if self.full.HasValue(context):
            return Aim.of(self.full.Eval(context))
        return Aim.of(self.pose.Eval(context))


def connect_target(
    builder: DiagramBuilder, target: OutputPort, system: LeafSystem
) -> None:
    """Connects the port of a plain pose or of an `Aim` to a matching input.

    Args:
        builder: Builder of the diagram.
        target: The output port of the target.
        system: The system, which has `TargetPorts`.
    """
    is_pose = isinstance(target.Allocate().get_value(), RigidTransform)
    name = "target" if is_pose else "aim"
    builder.Connect(target, system.GetInputPort(name))
