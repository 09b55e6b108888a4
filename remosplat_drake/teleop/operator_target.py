"""`OperatorTarget`: a target that an operator moves."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
    State,
)

from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.optional_input import value_or_none
from remosplat_drake.signals.supervisor_state import SupervisorState
from remosplat_drake.signals.target_state import TargetState
from remosplat_drake.task.target_sequence import TargetProgress
from remosplat_drake.teleop.hand_motion import HandLaw, advance_hand
from remosplat_drake.teleop.motion_law import MotionLaw
from remosplat_drake.teleop.target_motion import advance_target, stand


class OperatorTarget(LeafSystem):
    """Moves the target by the operator's requests, within bounds.

    .. pydrake_system::

        name: OperatorTarget
        input_ports:
        - configuration
        - command
        - map_requests (optional)
        - supervision (optional)
        - job (optional)
        output_ports:
        - target
        - aim
        - state
        - map_requests
        - hand_command (optional)

    The system replaces a `TargetSequence`, and never ends. `configuration`
    takes the measured q, `command` an `OperatorCommand`; `aim` outputs the
    `Aim`. For the end effector that the operator moves, `target` outputs only
    the target's pose X_WT, as a `RigidTransform`, and `state` the
    `TargetState`. The output `map_requests` contains the requests of the input,
    and requests for the frames of scans. `hand_command` outputs the hand's
    width and force [m, N]; without a hand, this port does not exist.

    The command selects the end effector that moves. All other end effectors are
    held at the pose at which they were deselected, or at their start.

    `supervision` takes a `SupervisorState`. While the robot is stopped, the
    target stays at the end effector. After a release, the robot therefore does
    not move to a target that an operator has moved in the meantime. This input
    affects the outputs only through the periodic update. Otherwise there would
    be an algebraic loop, since the supervisor's inputs depend on the target.

    `job` takes the description of a job's state, such as "pick the can: lifts
    the can", which is empty if there is no job. During a job, which moves the
    robot instead of the operator, the targets stay at the end effectors, and
    the hand is considered open. This input, too, affects only the periodic
    update.

    Args:
        robot: The robot, which computes the kinematics.
        q0: Configuration to start from, shape (n_q,).
        law: Bounds of the target's motion, or a sequence of bounds, one per end
            effector. Their `dt` is the period [s].
        hand: Commands to the hand; None for a robot without a hand.
    """

    def __init__(
        self,
        *,
        robot: RobotModel,
        q0: np.ndarray,
        law: MotionLaw | Sequence[MotionLaw],
        hand: HandLaw | None = None,
    ):
        super().__init__()
        self.set_name("targets")
        self._robot = robot
        self._laws = (law,) if isinstance(law, MotionLaw) else tuple(law)
        self._hand = hand
        assert len(self._laws) == len(robot.effectors)
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
        self._job_input = self.DeclareAbstractInputPort("job", Value(""))
        # The target has no pose until a tick has measured the end effector's
        # pose.
        nowhere = TargetState.at_rest(np.full((4, 4), np.nan))
        hands = _Hands((nowhere,) * len(self._laws))
        self._hands_index = self.DeclareAbstractState(Value(hands))
        self._X_WEs_expected = robot.end_effector_poses(q0)
        ticket = self.abstract_state_ticket(self._hands_index)
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
        if hand is not None:
            self.DeclareVectorOutputPort(
                "hand_command", 2, self._calc_hand, {ticket}
            )
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            self._laws[0].dt, 0.0, self._advance
        )

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
            map_requests: The operators' `MapRequests`; None without a live map.
            **arguments: The arguments of `OperatorTarget`.
        """
        target = builder.AddSystem(OperatorTarget(**arguments))
        builder.Connect(configuration, target.GetInputPort("configuration"))
        builder.Connect(command, target.GetInputPort("command"))
        if map_requests is not None:
            builder.Connect(map_requests, target.GetInputPort("map_requests"))
        return target

    def state(self, context: Context) -> TargetState:
        """Returns the target of the end effector that the operator moves.

        Args:
            context: The system's own context.
        """
        hands = self._known_hands(context)
        state = hands.led
        if len(hands.states) == 1:
            return state
        X_WTs = np.array([one.X_WT for one in hands.states])
        return dc.replace(state, effector=hands.leading, X_WTs=X_WTs)

    def _memory(self, context: Context) -> "_Hands":
        return context.get_abstract_state(int(self._hands_index)).get_value()

    def _known_hands(self, context: Context) -> "_Hands":
        """Returns all targets; before the first tick, each is at its hand."""
        hands = self._memory(context)
        if all(np.isfinite(one.X_WT).all() for one in hands.states):
            return hands
        X_WEs = self._end_effectors(context)
        known = np.isfinite(X_WEs).all()
        X_WEs = X_WEs if known else self._X_WEs_expected
        return dc.replace(hands, states=tuple(map(TargetState.at_rest, X_WEs)))

    def progress(self, context: Context) -> TargetProgress:
        """Returns the progress of a sequence that never ends: 0 of 1."""
        return TargetProgress(0, 1)

    def error(self, context: Context) -> PoseError:
        """Returns the error from the end effector to the target.

        Args:
            context: The system's own context.
        """
        leading = self._memory(context).leading
        target = self._aim(context).targets[leading]
        assert target is not None
        return target.error(self._end_effectors(context)[leading])

    def _aim(self, context: Context) -> Aim:
        states = self._known_hands(context).states
        return Aim(
            tuple(
                law.target(state)
                for law, state in zip(self._laws, states, strict=True)
            )
        )

    def _end_effectors(self, context: Context) -> np.ndarray:
        q = self._configuration_input.Eval(context)
        return self._robot.end_effector_poses(q)

    def _is_stopped(self, context: Context) -> bool:
        if not self._supervision_input.HasValue(context):
            return False
        return self._supervision_input.Eval(context).is_latched

    def _calc_target(self, context: Context, output: AbstractValue):
        output.set_value(RigidTransform(self.state(context).X_WT))

    def _calc_aim(self, context: Context, output: AbstractValue):
        output.set_value(self._aim(context))

    def _calc_state(self, context: Context, output: AbstractValue):
        output.set_value(self.state(context))

    def _calc_requests(self, context: Context, output: AbstractValue):
        states = self._memory(context).states
        requests = MapRequests(
            frames=sum(state.frames_wanted for state in states),
            unfinished=sum(state.unfinished for state in states),
        )
        if self._requests_input.HasValue(context):
            requests += self._requests_input.Eval(context)
        output.set_value(requests)

    def _calc_hand(self, context: Context, output: BasicVector):
        assert self._hand is not None
        is_open = self._memory(context).is_open
        output.SetFromVector(self._hand.command(is_open=is_open))

    def _advance(self, context: Context, state: State):
        X_WEs = self._end_effectors(context)
        before = self._memory(context)
        placed = np.array([one.X_WT for one in before.states])
        if not (np.isfinite(placed).all() or np.isfinite(X_WEs).all()):
            return
        before = self._known_hands(context)
        command = self._command_input.Eval(context)
        leading = before.leading
        if command.choices > before.led.command.choices:
            leading = self._index(command.effector)
        is_open, job = before.is_open, value_or_none(self._job_input, context)
        is_stopped = self._is_stopped(context)
        why = "hold: the robot is stopped" if is_stopped else job
        if job:
            is_open = True
        elif not is_stopped:
            known = before.led.command
            is_open = advance_hand(known, command, is_open=is_open)
        states = []
        for i, (law, one) in enumerate(
            zip(self._laws, before.states, strict=True)
        ):
            if why:
                one = stand(one, command, X_WEs[i], why)
            elif i == leading:
                time = context.get_time()
                one = advance_target(law, one, command, X_WEs[i], time)
            elif i == before.leading:
                one = stand(one, command, X_WEs[i], "hold: another hand moves")
            else:
                # The requests so far were for other end effectors. They are
                # stored, so that they do not count as new requests later.
                one = dc.replace(one, command=command)
            states.append(one)
        cell = int(self._hands_index)
        hands = _Hands(tuple(states), leading, is_open)
        state.get_mutable_abstract_state(cell).set_value(hands)

    def _index(self, effector: str) -> int:
        """Returns the index of an end effector; 0 for an unknown name."""
        names = self._robot.effectors
        return names.index(effector) if effector in names else 0


@dc.dataclass(frozen=True, eq=False)
class _Hands:
    """The targets of all end effectors; a deep copy is the object itself.

    Attributes:
        states: State of the target of each end effector.
        leading: Index of the end effector that the operator moves.
        is_open: Whether the robot's hand shall be open.
    """

    states: tuple[TargetState, ...]
    leading: int = 0
    is_open: bool = True

    def __deepcopy__(self, memo) -> "_Hands":
        return self

    @property
    def led(self) -> TargetState:
        """The target of the end effector that the operator moves."""
        return self.states[self.leading]
