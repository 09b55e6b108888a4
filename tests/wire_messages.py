"""Statuses of base and arm, as they come over the wire."""

from drake import lcmt_panda_status

from remosplat_drake.hardware.wire.messages.base_status import base_status


def base_message(**fields) -> bytes:
    """A status of a base that moves, with some fields replaced."""
    message = base_status()
    message.utime = 1_700_000_000_500_000
    message.pose = [1.0, 2.0, 0.5]
    message.forward, message.left, message.yaw_rate = 0.3, 0.05, -0.1
    message.mode = base_status.MOVING
    message.battery = 0.5
    for name, value in fields.items():
        setattr(message, name, value)
    return message.encode()


def arm_message(**fields) -> bytes:
    """A status of an arm that moves, with some fields replaced."""
    message = lcmt_panda_status()
    n = fields.pop("num_joints", 7)
    message.utime = 1_700_000_000_123_456
    message.robot_utime = 2_500_000
    message.num_joints = n
    for name in message.__slots__:
        if name.startswith("joint_"):
            setattr(message, name, [0.0] * n)
    message.joint_position = [0.1 * i for i in range(n)]
    message.joint_velocity = [-0.2 * i for i in range(n)]
    message.robot_mode = lcmt_panda_status.kMove
    message.control_command_success_rate = 0.98
    for name, value in fields.items():
        setattr(message, name, value)
    return message.encode()
