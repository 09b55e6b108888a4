"""`TrajectoryOperator`: outputs the timed requests of a script."""

from bisect import bisect_right
from collections.abc import Sequence

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.teleop.trajectory_file import (
    AccumulatedRequests,
    OperatorStep,
    accumulate_requests,
)

_ROUNDING = 1e-9
"""Tolerance of a step's time [s], for rounding errors in the times of ticks."""


class TrajectoryOperator(LeafSystem):
    """An operator with the timed requests of a script.

    .. pydrake_system::

        name: TrajectoryOperator
        output_ports:
        - command
        - map_requests

    `command` carries an `OperatorCommand`, `map_requests` the `MapRequests`.
    Times are measured from the initialisation of the simulation.

    Args:
        steps: The steps of the script, in the order of time.
        scenes: The scenes of a simulated camera, which shows the first scene at
            the start.
    """

    def __init__(
        self,
        *,
        steps: Sequence[OperatorStep],
        scenes: Sequence[PrimitiveScene] = (),
    ):
        super().__init__()
        self.set_name("trajectory_operator")
        self._asked = accumulate_requests(steps, scenes)
        self._times = [asked.time for asked in self._asked]
        self._start_index = self.DeclareDiscreteState(1)
        self.DeclareInitializationDiscreteUpdateEvent(self._begin)
        self.DeclareAbstractOutputPort(
            "command", Value(OperatorCommand()).Clone, self._calc_command
        )
        self.DeclareAbstractOutputPort(
            "map_requests", Value(MapRequests()).Clone, self._calc_requests
        )

    def _begin(self, context: Context, state: DiscreteValues):
        state.set_value(int(self._start_index), [context.get_time()])

    def _now(self, context: Context) -> AccumulatedRequests:
        start = context.get_discrete_state(int(self._start_index)).value()
        time = context.get_time() - start[0] + _ROUNDING
        return self._asked[bisect_right(self._times, time) - 1]

    def _calc_command(self, context: Context, output: AbstractValue):
        output.set_value(self._now(context).command)

    def _calc_requests(self, context: Context, output: AbstractValue):
        output.set_value(self._now(context).map_requests)
