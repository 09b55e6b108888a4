"""`MergedMovers`: merges the movers of several sources."""

from collections.abc import Sequence
from itertools import chain

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.scene.mover import Movers


def merge_movers(parts: Sequence[Movers]) -> Movers:
    """Merges the movers of several sources into one value.

    The stamp of the result is the oldest stamp, so that the supervisor detects
    a stale source.

    Args:
        parts: The movers of each source; at least one source.
    """
    return Movers(
        min(part.stamp for part in parts),
        list(chain(*parts)),
        list(chain(*(part.cameras for part in parts))),
        next((part.problem for part in parts if part.problem), ""),
    )


class MergedMovers(LeafSystem):
    """Merges the movers of several input ports.

    .. pydrake_system::

        name: MergedMovers
        input_ports:
        - movers_0 ...
        output_ports:
        - movers

    Args:
        count: Number of input ports.
    """

    def __init__(self, *, count: int):
        super().__init__()
        for i in range(count):
            self.DeclareAbstractInputPort(f"movers_{i}", Value[object]())
        self.DeclareAbstractOutputPort(
            "movers", lambda: Value[object](Movers(0.0)), self._calc_movers
        )

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, parts: Sequence[OutputPort]
    ) -> OutputPort | None:
        """Adds a `MergedMovers` to a diagram, if there are several ports.

        Args:
            builder: The builder of the diagram.
            parts: Output ports of `Movers`.

        Returns:
            The port with all movers. A single port is returned unchanged. It is
            None if there are no ports.
        """
        if len(parts) < 2:
            return parts[0] if parts else None
        system = builder.AddSystem(MergedMovers(count=len(parts)))
        for i, part in enumerate(parts):
            builder.Connect(part, system.get_input_port(i))
        return system.get_output_port()

    def _calc_movers(self, context: Context, output: AbstractValue):
        ports = range(self.num_input_ports())
        parts = [self.get_input_port(i).Eval(context) for i in ports]
        output.set_value(merge_movers(parts))
