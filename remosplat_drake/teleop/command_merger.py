"""`CommandMerger`: merges the commands of several operators."""

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    State,
    ValueProducer,
)

from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.teleop.merging import MergedCommand, merge_commands

_COMMAND, _REQUESTS = "command", "map_requests"


class CommandMerger(LeafSystem):
    """Outputs the newest request of several operators, and all button presses.

    .. pydrake_system::

        name: CommandMerger
        input_ports:
        - command_0 ...
        - map_requests_0 ... (optional)
        output_ports:
        - command
        - map_requests

    For each operator i, `command_i` takes an `OperatorCommand`, and
    `map_requests_i` takes `MapRequests`; the outputs have the same types. The
    outputs follow the inputs without delay. Once a period, the system stores
    the operator of the latest request (the leader).

    Args:
        count: Number of operators, at least one.
        period: Time between two updates of the stored leader [s].
    """

    def __init__(self, *, count: int, period: float):
        super().__init__()
        self.set_name("operators")
        self._commands = [
            self.DeclareAbstractInputPort(
                f"{_COMMAND}_{i}", Value(OperatorCommand())
            )
            for i in range(count)
        ]
        self._requests = [
            self.DeclareAbstractInputPort(
                f"{_REQUESTS}_{i}", Value(MapRequests())
            )
            for i in range(count)
        ]
        silent = Value(MergedCommand.silent(count))
        self._merged_index = self.DeclareAbstractState(silent)
        self._merged = self.DeclareCacheEntry(
            "merged",
            ValueProducer(allocate=silent.Clone, calc=self._calc_merged),
            {
                self.abstract_state_ticket(self._merged_index),
                *(port.ticket() for port in self._commands),
            },
        )
        self.DeclareAbstractOutputPort(
            _COMMAND,
            Value(OperatorCommand()).Clone,
            self._calc_command,
            {self._merged.ticket()},
        )
        self.DeclareAbstractOutputPort(
            _REQUESTS,
            Value(MapRequests()).Clone,
            self._calc_requests,
            {port.ticket() for port in self._requests},
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._remember)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, sources: list[LeafSystem], period: float
    ) -> "CommandMerger":
        """Adds a merger to a diagram, and connects the operators to it.

        Args:
            builder: Builder of the diagram.
            sources: The operators: systems with an output port `command`. The
                port `map_requests` of an operator is used, too.
            period: Time between two updates of the stored leader [s].
        """
        merger = builder.AddSystem(
            CommandMerger(count=len(sources), period=period)
        )
        for i, source in enumerate(sources):
            for name in (_COMMAND, _REQUESTS):
                if source.HasOutputPort(name):
                    builder.Connect(
                        source.GetOutputPort(name),
                        merger.GetInputPort(f"{name}_{i}"),
                    )
        return merger

    def _calc_merged(self, context: Context, value: AbstractValue):
        cell = int(self._merged_index)
        before = context.get_abstract_state(cell).get_value()
        commands = [port.Eval(context) for port in self._commands]
        value.set_value(merge_commands(before, commands))

    def _calc_command(self, context: Context, output: AbstractValue):
        output.set_value(self._merged.Eval(context).command)

    def _calc_requests(self, context: Context, output: AbstractValue):
        total = MapRequests()
        for port in self._requests:
            if port.HasValue(context):
                total += port.Eval(context)
        output.set_value(total)

    def _remember(self, context: Context, state: State):
        cell = int(self._merged_index)
        state.get_mutable_abstract_state(cell).set_value(
            self._merged.Eval(context)
        )
