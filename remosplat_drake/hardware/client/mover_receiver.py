"""`MoverReceiver`: the system that receives movers over LCM."""

import dataclasses as dc

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import Context, LeafSystem

from remosplat_drake.hardware.client.heard_movers import (
    NONE_HEARD,
    HeardMovers,
    with_movers,
)
from remosplat_drake.hardware.client.mailbox import Mailbox
from remosplat_drake.hardware.mover_sensing_config import MoverSensingConfig


class MoverReceiver(LeafSystem):
    """Outputs the latest valid movers (moving objects) that arrived by LCM.

    .. pydrake_system::

        name: MoverReceiver
        output_ports:
        - movers

    `receive` stores the newest packet of a mailbox in the state. `movers` are
    the latest `Movers`, with the stamp of their image. See `HeardMovers` for
    unusable messages.

    Args:
        mailbox: The mailbox of the movers' channel.
        config: Settings, with the limits of valid movers.
    """

    def __init__(self, *, mailbox: Mailbox, config: MoverSensingConfig):
        super().__init__()
        self._mailbox, self._config = mailbox, config
        self._cell = self.DeclareAbstractState(Value[object](HeardMovers()))
        self.DeclareAbstractOutputPort(
            "movers",
            Value[object](NONE_HEARD).Clone,
            self._calc_movers,
            {self.abstract_state_ticket(self._cell)},
        )

    def receive(self, context: Context) -> None:
        """Stores the newest packet in the state.

        Args:
            context: The system's own context, between two steps.
        """
        box, heard = self._mailbox, self.heard(context)
        if box.data is None or box.count == heard.count:
            return
        heard = with_movers(heard, box.data, box.received, self._config)
        value = context.get_mutable_abstract_state(int(self._cell))
        value.set_value(dc.replace(heard, count=box.count))

    def heard(self, context: Context) -> HeardMovers:
        """Returns the movers received so far.

        Args:
            context: The system's own context.
        """
        return context.get_abstract_state(int(self._cell)).get_value()

    def _calc_movers(self, context: Context, output: AbstractValue):
        output.set_value(self.heard(context).movers)
