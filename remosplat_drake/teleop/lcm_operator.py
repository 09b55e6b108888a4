"""`LcmOperator`: moves the target as LCM messages request."""

import time
from collections.abc import Callable

from pydrake.common.value import AbstractValue, Value
from pydrake.lcm import DrakeLcm
from pydrake.systems.framework import Context, LeafSystem, State

from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.teleop.target_stream import (
    POSES,
    VELOCITIES,
    StreamState,
    advance_stream,
    merged_command,
)
from remosplat_drake.teleop.teleop_config import PoseStreamConfig


class LcmOperator(LeafSystem):
    """Receives `pose_target` and `velocity_target` messages.

    .. pydrake_system::

        name: LcmOperator
        output_ports:
        - command

    `command` outputs an `OperatorCommand`. The wall clock determines the ages
    of messages, even if the simulation is slower or faster than real time.

    Args:
        config: LCM URL, channels and expiry time of the messages.
        lcm: The LCM network; None opens the network at the URL in `config`.
        period: Time between two reads of the network [s].
        clock: Function that returns the wall clock's time [s].
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
        self._packets: dict[str, bytes] = {}
        self._channels = config.channel, config.velocity_channel
        for channel in self._channels:
            self._lcm.Subscribe(channel, self._receiver(channel))
        stream = StreamState(OperatorCommand(effector=config.effector))
        self._streams_index = self.DeclareAbstractState(
            Value[object]((stream, stream))
        )
        self.DeclareAbstractOutputPort(
            "command",
            Value(OperatorCommand()).Clone,
            self._calc_command,
            {self.abstract_state_ticket(self._streams_index)},
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._listen)

    def _receiver(self, channel: str) -> Callable[[bytes], None]:
        return lambda data: self._packets.update({channel: bytes(data)})

    def _streams(self, context: Context) -> tuple[StreamState, StreamState]:
        index = int(self._streams_index)
        return context.get_abstract_state(index).get_value()

    def _listen(self, context: Context, state: State):
        self._packets.clear()
        self._lcm.HandleSubscriptions(0)
        streams = tuple(
            advance_stream(
                kind,
                stream,
                self._packets.get(channel),
                self._clock(),
                self._expiry,
            )
            for kind, stream, channel in zip(
                (POSES, VELOCITIES),
                self._streams(context),
                self._channels,
                strict=True,
            )
        )
        cell = int(self._streams_index)
        state.get_mutable_abstract_state(cell).set_value(streams)

    def _calc_command(self, context: Context, output: AbstractValue):
        output.set_value(merged_command(self._streams(context)))
