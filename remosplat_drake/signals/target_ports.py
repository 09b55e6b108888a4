"""Input ports for the target of a system."""

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
    """A system's two input ports for its target, of which one is connected.

    Attributes:
        pose: The pose X_WT of a plain target, a `RigidTransform`.
        full: An `Aim`, or a `Target` of the first end effector; takes
            precedence if both are connected.
    """

    pose: InputPort
    full: InputPort

    @staticmethod
    def declare(system: LeafSystem) -> "TargetPorts":
        """Declares the inputs `target` and `aim`.

        Args:
            system: The system, under construction.
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
    """Connects a target, a plain pose or an `Aim`, to the matching input.

    Args:
        builder: Builder of the diagram.
        target: The port of the target.
        system: The system, with `TargetPorts`.
    """
    is_pose = isinstance(target.Allocate().get_value(), RigidTransform)
    name = "target" if is_pose else "aim"
    builder.Connect(target, system.GetInputPort(name))
