"""Converts states in the 1 kHz callback to messages of `PANDA_STATUS`."""

from typing import Any

from drake import lcmt_panda_status

from remosplat_drake.hardware.drivers.panda_commands import JOINTS
from remosplat_drake.hardware.drivers.panda_limits import JointCommand

_VECTORS = ("q", "q_d", "dq", "tau_J", "tau_J_d", "tau_ext_hat_filtered")
_FIELDS = (
    "joint_position",
    "joint_position_desired",
    "joint_velocity",
    "joint_torque",
    "joint_torque_desired",
    "joint_torque_external",
    "joint_velocity_desired",
    "joint_acceleration_desired",
)
_SCALARS = 4

RECORD_SIZE = _SCALARS + JOINTS * len(_FIELDS)
"""Number of values that `arm_record` returns."""


def arm_record(
    state: Any, command: JointCommand, now: int
) -> tuple[float, ...]:
    """Lists the values from which a status is made.

    Args:
        state: A `RobotState` of libfranka.
        command: The command that answers this state.
        now: Wall clock [us]; a double represents it exactly until the year
            2255.
    """
    values = [
        now,
        state.robot_mode.value,
        state.control_command_success_rate,
        state.time.to_msec(),
    ]
    for name in _VECTORS:
        values += getattr(state, name)
    values += command.velocity.tolist()
    values += command.acceleration.tolist()
    return tuple(values)


def panda_status(record: tuple[float, ...]) -> lcmt_panda_status:
    """Makes the status message that drake-franka-driver would make.

    Args:
        record: The result of `arm_record`.
    """
    status = lcmt_panda_status()
    now, mode, success_rate, milliseconds = record[:_SCALARS]
    status.utime = round(now)
    status.num_joints = JOINTS
    for i, field in enumerate(_FIELDS):
        start = _SCALARS + JOINTS * i
        setattr(status, field, list(record[start : start + JOINTS]))
    status.control_command_success_rate = success_rate
    status.robot_mode = round(mode)
    status.robot_utime = round(1000 * milliseconds)
    return status
