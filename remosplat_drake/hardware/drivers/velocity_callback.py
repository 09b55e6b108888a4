"""`VelocityCallback`: the function that libfranka calls once a millisecond.

It exchanges setpoints and states with the other process by shared memory, so it
never waits.
"""

import time
from collections.abc import Callable
from typing import Any

from remosplat_drake.base.clock import wall_utime
from remosplat_drake.hardware.drivers.arm_record import arm_record
from remosplat_drake.hardware.drivers.shared_record import SharedRecord
from remosplat_drake.hardware.drivers.velocity_servo import VelocityServo

SETPOINT_SIZE = 9
"""Number of values of a setpoint: its time by `time.monotonic` [s], a flag that
is not 0 if the motion shall end, and seven joint rates [rad/s]."""


class VelocityCallback:
    """Answers each state of the robot with joint rates."""

    def __init__(
        self,
        servo: VelocityServo,
        setpoints: SharedRecord,
        states: SharedRecord,
        joint_velocities: Callable[[list[float]], Any],
    ):
        """Stores the servo and the records of the shared memory.

        Args:
            servo: Computes the commands.
            setpoints: Shared record that the other process writes.
            states: Shared record that the other process reads.
            joint_velocities: Libfranka's class `JointVelocities`.
        """
        self._servo = servo
        self._setpoints = setpoints
        self._states = states
        self._joint_velocities = joint_velocities

    def __call__(self, state: Any, period: Any) -> Any:
        """Returns the `JointVelocities` that answer a state.

        Args:
            state: A `RobotState`.
            period: The `Duration` since the last call. It is more than 1 ms if
                packets were lost.
        """
        # The robot extrapolates its motion if packets are lost, and also if an
        # answer is late. In the second case, the period is 1 ms. In the first
        # one, the rates may equal the command while accelerations differ.
        servo = self._servo
        if period.to_msec() > 1 or not servo.is_executed(state.dq_d):
            servo.resume(state.dq_d, state.ddq_d)
        written, end, *setpoint = self._setpoints.read()
        age = time.monotonic() - written
        command = servo.step(setpoint, age, bool(end))
        self._states.write(arm_record(state, command, wall_utime()))
        answer = self._joint_velocities(command.velocity.tolist())
        answer.motion_finished = servo.is_finished
        return answer
