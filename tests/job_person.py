"""An operator of a test, with requests for jobs and frames."""

import dataclasses as dc

from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.operator_command import OperatorCommand


class Person(LeafSystem):
    """An operator whose requests are those of the test."""

    def __init__(self):
        super().__init__()
        self.command = OperatorCommand(source="person")
        self.DeclareAbstractOutputPort(
            "command",
            Value(self.command).Clone,
            lambda context, output: output.set_value(self.command),
            {self.time_ticket()},
        )
        self.map_requests = MapRequests()
        self.DeclareAbstractOutputPort(
            "map_requests",
            Value(self.map_requests).Clone,
            lambda context, output: output.set_value(self.map_requests),
            {self.time_ticket()},
        )

    def ask(self, count: str, **values) -> None:
        """Makes another request.

        Args:
            count: The field of the command that counts such requests.
            **values: Other fields of the command.
        """
        values[count] = getattr(self.command, count) + 1
        self.command = dc.replace(self.command, **values)

    def take_frame(self) -> None:
        """Requests a frame and a map."""
        self.map_requests += MapRequests(frames=1)
