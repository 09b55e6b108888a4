"""`MotionPredictor`: predicts the motion of a robot with delay."""

import dataclasses as dc
import math

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    LeafSystem,
    State,
    ValueProducer,
)

from remosplat_drake.controller.prediction.history import History
from remosplat_drake.controller.prediction.predict import predict
from remosplat_drake.controller.prediction.station_ramp import StationRamp
from remosplat_drake.robot.actuators import ActuatorModel
from remosplat_drake.robot.braking import spare_time
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.motion import Motion
from remosplat_drake.signals.station_status import StationStatus

_RENEWED = 0.1
"""Weight of the latest value in the running average of the latency."""


@dc.dataclass(frozen=True, eq=False)
class _Known:
    """The system's state between ticks; copying returns the object itself.

    Attributes:
        time: Time of the previous tick [s]; NaN before the first.
        latency: Running average of the time from a tick to the sending of its
            command [s].
        history: Commands and measurements.
    """

    time: float
    latency: float
    history: History

    def __deepcopy__(self, memo) -> "_Known":
        return self

    def with_command(
        self,
        model: ActuatorModel,
        sent: float,
        u: np.ndarray,
        ramp: StationRamp,
    ) -> "_Known":
        """Adds the previous tick's command and the time of its sending."""
        sent = max(self.time, sent)
        change = sent - self.time - self.latency
        return dc.replace(
            self,
            latency=self.latency + _RENEWED * change,
            history=self.history.with_command(model, sent, u, ramp),
        )


class MotionPredictor(LeafSystem):
    """Predicts the robot's state at the time when the next command acts.

    .. pydrake_system::

        name: MotionPredictor
        input_ports:
        - configuration
        - odometry
        - status
        - velocity_executed
        - base_velocity (optional)
        output_ports:
        - configuration
        - motion

    The input `status` contains the age of the measured q. If a station
    extrapolates the pose of its base with the measured `base_velocity`, this
    system reverses the extrapolation with the same velocity. The input
    `velocity_executed` is the command of the previous tick, and `status`
    contains the time at which it was sent. The expected latency of the next
    command is a running average. The output `configuration` is the
    configuration after all commands in flight, from which the controller
    computes the next command. The output `motion` is the `Motion`, for
    verification and for the supervisor.

    Args:
        robot: The robot.
        model: Actuator model of the robot's axes.
        period: Control period [s].
    """

    def __init__(
        self,
        *,
        robot: RobotModel,
        model: ActuatorModel,
        period: float,
    ):
        super().__init__()
        self.set_name("predictor")
        self._robot, self._model = robot, model
        self._ramp = StationRamp(robot.acceleration_limit, period)
        # This is the time from a tick that is on time to the start of a
        # station's braking ramp.
        self._slack = spare_time(period)
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._odometry_input = self.DeclareVectorInputPort(
            "odometry", robot.n_q
        )
        self._status_input = self.DeclareAbstractInputPort(
            "status", Value(StationStatus())
        )
        self._executed_input = self.DeclareVectorInputPort(
            "velocity_executed", robot.n_u
        )
        self._base_input = self.DeclareVectorInputPort(
            "base_velocity", robot.n_base
        )
        start = _Known(math.nan, 0.0, History.at_rest(robot.n_u))
        self._cell = int(self.DeclareAbstractState(Value[object](start)))
        self._history = self.DeclareCacheEntry(
            "history",
            ValueProducer(allocate=Value[object], calc=self._calc_history),
        )
        self._motion = self.DeclareCacheEntry(
            "motion", ValueProducer(allocate=Value[object], calc=self._calc)
        )
        self.DeclareVectorOutputPort(
            "configuration", robot.n_q, self._calc_configuration
        )
        self.DeclareAbstractOutputPort(
            "motion", Value[object], self._calc_motion
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._tick)

    def _calc_history(self, context: Context, value: Value) -> None:
        """Returns the state with the command of the previous tick."""
        known: _Known = context.get_abstract_state(self._cell).get_value()
        if not math.isnan(known.time):
            known = known.with_command(
                self._model,
                self._status_input.Eval(context).sent,
                self._executed_input.Eval(context),
                self._ramp,
            )
        value.set_value(known)

    def _calc(self, context: Context, value: Value) -> None:
        known: _Known = self._history.Eval(context)
        q = self._measured(context, self._configuration_input)
        stamp = self._stamp(context)
        sends = context.get_time() + known.latency
        value.set_value(
            predict(
                self._robot,
                self._model,
                known.history,
                q,
                stamp,
                sends,
                self._slack,
            )
        )

    def _stamp(self, context: Context) -> np.ndarray:
        status, n = self._status_input.Eval(context), self._robot.n_base
        ages = [status.base_age] * n + [status.age] * (self._robot.n_u - n)
        return context.get_time() - np.array(ages)

    def _measured(self, context: Context, port) -> np.ndarray:
        """Returns a port's q, with the base's pose when it was measured."""
        q = np.array(port.Eval(context))
        age = self._status_input.Eval(context).base_age
        if age and self._base_input.HasValue(context):
            u = np.zeros(self._robot.n_u)
            u[: self._robot.n_base] = self._base_input.Eval(context)
            q = self._robot.advance(q, u, -age)
        return q

    def _tick(self, context: Context, state: State) -> None:
        known: _Known = self._history.Eval(context)
        way = self._motion.Eval(context).way_measured
        q = self._measured(context, self._odometry_input)
        known = dc.replace(
            known,
            time=context.get_time(),
            history=known.history.with_measurement(q, way, self._robot.n_base),
        )
        state.get_mutable_abstract_state(self._cell).set_value(known)

    def _calc_configuration(self, context: Context, output: BasicVector):
        motion: Motion = self._motion.Eval(context)
        output.SetFromVector(motion.q_planned)

    def _calc_motion(self, context: Context, output: Value) -> None:
        output.set_value(self._motion.Eval(context))
