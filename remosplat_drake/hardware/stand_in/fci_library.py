"""A replacement for `panda_py.libfranka` that connects to an `FciArm`.

With this module, the real driver of the arm controls the simulated arm. It
contains only the classes and functions that the driver uses.
"""

import dataclasses as dc
import math
import socket
import struct
from collections.abc import Callable, Sequence
from enum import Enum

from remosplat_drake.hardware.stand_in.fci_packets import (
    LARGEST,
    Kind,
    Request,
    State,
)


class RealtimeConfig(Enum):
    """Whether a real-time kernel is required; has no effect in this module."""

    kEnforce = 0
    kIgnore = 1


class ControllerMode(Enum):
    """The arm's own controller of joint velocities."""

    kJointImpedance = 0
    kCartesianImpedance = 1


class RobotMode(Enum):
    """The arm's mode."""

    kOther = 0
    kIdle = 1
    kMove = 2
    kGuiding = 3
    kReflex = 4
    kUserStopped = 5
    kAutomaticErrorRecovery = 6


@dc.dataclass(frozen=True)
class Duration:
    """A duration of whole milliseconds."""

    milliseconds: int = 0

    def to_msec(self) -> int:
        """Returns the duration [ms]."""
        return self.milliseconds


@dc.dataclass
class JointVelocities:
    """Seven commanded joint rates [rad/s], and whether they end the motion."""

    dq: Sequence[float]
    motion_finished: bool = False


@dc.dataclass(frozen=True)
class RobotState:
    """State of the robot, with libfranka's names; vectors have 7 entries."""

    q: list[float]
    q_d: list[float]
    dq: list[float]
    dq_d: list[float]
    ddq_d: list[float]
    tau_J: list[float]
    tau_J_d: list[float]
    tau_ext_hat_filtered: list[float]
    robot_mode: RobotMode
    control_command_success_rate: float
    time: Duration


class Robot:
    """A connection to an `FciArm`."""

    def __init__(
        self,
        franka_address: str,
        realtime_config: RealtimeConfig = RealtimeConfig.kIgnore,
    ):
        """Connects.

        Args:
            franka_address: UDP port of this computer, in digits.
            realtime_config: Has no effect in this module.
        """
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        # With `settimeout`, every call would wait, even with DONTWAIT.
        self._socket.setsockopt(
            socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("ll", 1, 0)
        )
        self._socket.connect(("127.0.0.1", int(franka_address)))

    def read_once(self) -> RobotState:
        """Requests and returns a state.

        Raises:
            RuntimeError: No answer comes.
        """
        return _robot_state(self._ask(Request(Kind.READ)))

    def set_collision_behavior(
        self,
        lower_torque_thresholds: Sequence[float],
        upper_torque_thresholds: Sequence[float],
        lower_force_thresholds: Sequence[float],
        upper_force_thresholds: Sequence[float],
    ) -> None:
        """Sets the upper collision thresholds.

        Raises:
            RuntimeError: No answer comes.
        """
        values = (*upper_torque_thresholds, *upper_force_thresholds)
        self._ask(Request(Kind.COLLISION, values=values))

    def set_joint_impedance(self, K_theta: Sequence[float]) -> None:
        """Sets the joints' stiffness [N m/rad], which has no effect here."""

    def control_joint_velocity(
        self,
        motion_generator_callback: Callable[
            [RobotState, Duration], JointVelocities
        ],
        controller_mode: ControllerMode = ControllerMode.kJointImpedance,
        limit_rate: bool = True,
        cutoff_frequency: float = 100.0,
    ) -> None:
        """Answers every state by a callback until the callback ends the motion.

        Unlike libfranka, this function neither limits nor filters the rates.

        Raises:
            RuntimeError: The robot has aborted the motion, or does not answer.
            ValueError: The callback's rates are not finite.
        """
        state = self._ask(Request(Kind.BEGIN))
        previous = state.number
        while True:
            _check_motion(state)
            period = Duration(state.number - previous)
            previous = state.number
            answer = motion_generator_callback(_robot_state(state), period)
            if not all(map(math.isfinite, answer.dq)):
                raise ValueError("Commanding value is infinite or NaN.")
            last = answer.motion_finished
            kind = Kind.LAST if last else Kind.COMMAND
            self._send(Request(kind, state.number, tuple(answer.dq)))
            state = self._latest()
            if last and state.mode == RobotMode.kIdle.value:
                return

    def _ask(self, request: Request) -> State:
        self._send(request)
        return self._latest()

    def _send(self, request: Request) -> None:
        try:
            self._socket.send(request.encode())
        except OSError as error:
            raise RuntimeError(f"libfranka: UDP send: {error}") from error

    def _latest(self) -> State:
        """Waits up to a second for a state, and returns the latest."""
        try:
            data = self._socket.recv(LARGEST)
        except OSError as error:
            raise RuntimeError("libfranka: UDP receive: Timeout") from error
        while True:
            try:
                data = self._socket.recv(LARGEST, socket.MSG_DONTWAIT)
            except OSError:
                break
        try:
            return State.decode(data)
        except ValueError as error:
            raise RuntimeError(f"libfranka: UDP receive: {error}") from error


def _check_motion(state: State) -> None:
    if state.mode == RobotMode.kMove.value:
        return
    if state.mode == RobotMode.kUserStopped.value:
        raise RuntimeError(
            "libfranka: Move command aborted: User Stop pressed!"
        )
    raise RuntimeError(
        "libfranka: Move command aborted: motion aborted by reflex!"
        f' ["{state.error}"]'
    )


def _robot_state(state: State) -> RobotState:
    vectors = [list(state.vectors[7 * i : 7 * i + 7]) for i in range(8)]
    return RobotState(
        *vectors,
        robot_mode=RobotMode(state.mode),
        control_command_success_rate=state.success_rate,
        time=Duration(state.number),
    )
