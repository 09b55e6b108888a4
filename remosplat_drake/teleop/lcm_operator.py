"""`LcmOperator`: another program moves the target, by LCM messages."""

import time
from collections.abc import Callable

from pydrake.common.value import AbstractValue, Value
from pydrake.lcm import DrakeLcm
from pydrake.systems.framework import Context, LeafSystem, State

from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.teleop.pose_stream import (
    SOURCE,
    StreamState,
    advance_stream,
)
from remosplat_drake.teleop.teleop_config import PoseStreamConfig


class LcmOperator(LeafSystem):
    """An operator that listens for `pose_target` messages.

    .. pydrake_system::

        name: LcmOperator
        output_ports:
        - command

    `command` carries an `OperatorCommand`. Ages are by the wall clock,
    at each pace of the simulation.

    Args:
        config: LCM URL, channel and expiry time of the messages.
        lcm: The LCM network; None opens the one that the config names.
        period: Time between two looks at the network [s].
        clock: Returns the wall clock [s].
    """

    def __init__(
        self,
        *,
        config: PoseStreamConfig,
        period: float,
        lcm: DrakeLcm | None = None,
        clock: Callable[[], float] = time.time,
    ):
        super().__init__()
        self.set_name("lcm_operator")
        self._expiry = config.expiry
        self._clock = clock
        self._lcm = lcm or DrakeLcm(config.lcm_url)
        self._packet: bytes | None = None
        self._lcm.Subscribe(config.channel, self._receive)
        command = OperatorCommand(source=SOURCE, effector=config.effector)
        self._stream_index = self.DeclareAbstractState(
            Value(StreamState(command))
        )
        self.DeclareAbstractOutputPort(
            "command",
            Value(OperatorCommand()).Clone,
            self._calc_command,
            {self.abstract_state_ticket(self._stream_index)},
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._listen)

    def _receive(self, data: bytes) -> None:
        self._packet = bytes(data)

    def _stream(self, context: Context) -> StreamState:
        return context.get_abstract_state(int(self._stream_index)).get_value()

    def _listen(self, context: Context, state: State):
        self._packet = None
        self._lcm.HandleSubscriptions(0)
        stream = advance_stream(
            self._stream(context), self._packet, self._clock(), self._expiry
        )
        cell = int(self._stream_index)
        state.get_mutable_abstract_state(cell).set_value(stream)

    def _calc_command(self, context: Context, output: AbstractValue):
        output.set_value(self._stream(context).command)
