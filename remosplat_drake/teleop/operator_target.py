"""`OperatorTarget`: a target that an operator moves."""

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
    State,
)

from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.supervisor_state import SupervisorState
from remosplat_drake.signals.target import Target
from remosplat_drake.signals.target_state import TargetState
from remosplat_drake.task.target_sequence import TargetProgress
from remosplat_drake.teleop.motion_law import MotionLaw
from remosplat_drake.teleop.target_motion import advance_target, stand


class OperatorTarget(LeafSystem):
    """Moves the target as the operator asks, within bounds.

    .. pydrake_system::

        name: OperatorTarget
        input_ports:
        - configuration
        - command
        - map_requests (optional)
        - supervision (optional)
        output_ports:
        - target
        - aim
        - state
        - map_requests

    It stands in the place of a `TargetSequence` that never ends.
    `configuration` takes the measured q, `command` an `OperatorCommand`;
    `aim` gives the `Target`, `target` its pose X_WT alone as a
    `RigidTransform`, and `state` the `TargetState`. The outgoing `map_requests`
    are those that come in and the frames that scans want.

    `supervision` takes a `SupervisorState`. While the robot is stopped the
    target stays with it, so that a release does not send the robot off to
    where somebody wished it meanwhile. The outputs do not depend on this
    input but by the periodic update: what the supervisor sees depends on the
    target.

    Args:
        robot: The robot, for its kinematics.
        q0: Configuration to start from, shape (n_q,).
        law: Bounds of the motion; its `dt` is the period [s].
    """

    def __init__(self, *, robot: RobotModel, q0: np.ndarray, law: MotionLaw):
        super().__init__()
        self.set_name("targets")
        self._robot = robot
        self._law = law
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._command_input = self.DeclareAbstractInputPort(
            "command", Value(OperatorCommand())
        )
        self._requests_input = self.DeclareAbstractInputPort(
            "map_requests", Value(MapRequests())
        )
        self._supervision_input = self.DeclareAbstractInputPort(
            "supervision", Value(SupervisorState(np.zeros(robot.n_u)))
        )
        # Without a pose until a tick knows where the end effector is.
        nowhere = TargetState.at_rest(np.full((4, 4), np.nan))
        self._state_index = self.DeclareAbstractState(Value(nowhere))
        self._X_WE_expected = robot.end_effector_pose(q0)
        ticket = self.abstract_state_ticket(self._state_index)
        tickets = {ticket, self._configuration_input.ticket()}
        self.DeclareAbstractOutputPort(
            "target", Value(RigidTransform()).Clone, self._calc_target, tickets
        )
        self.DeclareAbstractOutputPort(
            "aim", Value[object]().Clone, self._calc_aim, tickets
        )
        self.DeclareAbstractOutputPort(
            "state", Value(nowhere).Clone, self._calc_state, tickets
        )
        self.DeclareAbstractOutputPort(
            "map_requests",
            Value(MapRequests()).Clone,
            self._calc_requests,
            {ticket, self._requests_input.ticket()},
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(law.dt, 0.0, self._advance)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        configuration: OutputPort,
        command: OutputPort,
        map_requests: OutputPort | None = None,
        **arguments,
    ) -> "OperatorTarget":
        """Adds a target to a diagram, and connects its inputs.

        Args:
            builder: Builder of the diagram.
            configuration: The measured configuration q.
            command: The `OperatorCommand`.
            map_requests: The operators' `MapRequests`; None for none.
            **arguments: The arguments of `OperatorTarget`.
        """
        target = builder.AddSystem(OperatorTarget(**arguments))
        builder.Connect(configuration, target.GetInputPort("configuration"))
        builder.Connect(command, target.GetInputPort("command"))
        if map_requests is not None:
            builder.Connect(map_requests, target.GetInputPort("map_requests"))
        return target

    def state(self, context: Context) -> TargetState:
        """Returns the present target.

        Args:
            context: The system's own context.
        """
        state = self._memory(context)
        if np.isfinite(state.X_WT).all():
            return state
        X_WE = self._end_effector(context)
        known = np.isfinite(X_WE).all()
        return TargetState.at_rest(X_WE if known else self._X_WE_expected)

    def _memory(self, context: Context) -> TargetState:
        return context.get_abstract_state(int(self._state_index)).get_value()

    def progress(self, context: Context) -> TargetProgress:
        """Returns the progress of a sequence that never ends: 0 of 1."""
        return TargetProgress(0, 1)

    def error(self, context: Context) -> PoseError:
        """Returns the error from the end effector to the target.

        Args:
            context: The system's own context.
        """
        return self._target(context).error(self._end_effector(context))

    def _target(self, context: Context) -> Target:
        return self._law.target(self.state(context))

    def _end_effector(self, context: Context) -> np.ndarray:
        q = self._configuration_input.Eval(context)
        return self._robot.end_effector_pose(q)

    def _is_stopped(self, context: Context) -> bool:
        if not self._supervision_input.HasValue(context):
            return False
        return self._supervision_input.Eval(context).is_latched

    def _calc_target(self, context: Context, output: AbstractValue):
        output.set_value(RigidTransform(self.state(context).X_WT))

    def _calc_aim(self, context: Context, output: AbstractValue):
        output.set_value(self._target(context))

    def _calc_state(self, context: Context, output: AbstractValue):
        output.set_value(self.state(context))

    def _calc_requests(self, context: Context, output: AbstractValue):
        state = self._memory(context)
        requests = MapRequests(
            frames=state.frames_wanted, unfinished=state.unfinished
        )
        if self._requests_input.HasValue(context):
            requests += self._requests_input.Eval(context)
        output.set_value(requests)

    def _advance(self, context: Context, state: State):
        X_WE = self._end_effector(context)
        placed = [self._memory(context).X_WT, X_WE]
        if not np.isfinite(placed).all(axis=(1, 2)).any():
            return
        before = self.state(context)
        command = self._command_input.Eval(context)
        if self._is_stopped(context):
            advanced = stand(before, command, X_WE)
        else:
            advanced = advance_target(
                self._law, before, command, X_WE, context.get_time()
            )
        cell = int(self._state_index)
        state.get_mutable_abstract_state(cell).set_value(advanced)
