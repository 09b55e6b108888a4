"""`ToldOperator`: an operator that a program controls."""

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import Context, LeafSystem

from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.operator_command import OperatorCommand


class ToldOperator(LeafSystem):
    """Outputs commands that a program sets between two simulation steps.

    .. pydrake_system::

        name: ToldOperator
        output_ports:
        - command
        - map_requests

    `command` carries an `OperatorCommand`, `map_requests` the `MapRequests`.
    """

    def __init__(self):
        super().__init__()
        self.set_name("told_operator")
        self._cells = {}
        for name, first in (
            ("command", OperatorCommand()),
            ("map_requests", MapRequests()),
        ):
            index = self.DeclareAbstractState(Value(first))
            self._cells[name] = int(index)
            self.DeclareStateOutputPort(name, index)

    def say(
        self,
        context: Context,
        command: OperatorCommand,
        map_requests: MapRequests,
    ) -> None:
        """Changes the outputs of the system.

        Args:
            context: The system's own context, between two steps.
            command: Operator's command: all requests to the target so far.
            map_requests: Requests to the map so far.
        """
        self._cell(context, "command").set_value(command)
        self._cell(context, "map_requests").set_value(map_requests)

    def _cell(self, context: Context, name: str) -> AbstractValue:
        return context.get_mutable_abstract_state(self._cells[name])
