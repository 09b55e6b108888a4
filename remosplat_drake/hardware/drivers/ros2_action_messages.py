"""Messages of the action control_msgs/GripperCommand as DDS types.

See `ros2_messages`.
"""

# The package annotates neither its class arguments nor its array lengths.
# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import dataclasses as dc
import struct

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, int8, sequence, uint8

from remosplat_drake.hardware.drivers.ros2_messages import (
    GripperCommand,
    Time,
)

_ENCAPSULATION = 4
"""Length of the prefix that states how a message is encoded [bytes]."""

_HEADER = 16
"""Length of the identity of client and request in a service's messages [bytes].
"""


def client_header(client: bytes, number: int) -> bytes:
    """Encodes the identity that CycloneDDS's ROS layer adds to a request.

    Args:
        client: The client's identifier, 8 bytes.
        number: Number of the request.
    """
    return client + struct.pack("<q", number)


@dc.dataclass
@final
class UUID(IdlStruct, typename="unique_identifier_msgs::msg::dds_::UUID_"):
    """unique_identifier_msgs/UUID: the identifier of a goal."""

    uuid: array[uint8, 16] = bytes(16)


@dc.dataclass
@final
class Goal(
    IdlStruct, typename="control_msgs::action::dds_::GripperCommand_Goal_"
):
    """The goal of control_msgs/action/GripperCommand."""

    command: GripperCommand = dc.field(default_factory=GripperCommand)


@dc.dataclass
@final
class GoalRequest(
    IdlStruct,
    typename="control_msgs::action::dds_::GripperCommand_SendGoal_Request_",
):
    """A request to move the gripper.

    The attribute `client` is the client's identity, which is encoded before the
    fields; empty if the request contains none.
    """

    goal_id: UUID = dc.field(default_factory=UUID)
    goal: Goal = dc.field(default_factory=Goal)

    def __post_init__(self):
        """Starts without a client's identity."""
        self.client = b""

    @classmethod
    def of(cls, goal: bytes, position: float, force: float) -> "GoalRequest":
        """Makes a request.

        Args:
            goal: Identifier of the goal, 16 bytes.
            position: Commanded position, in the controller's unit.
            force: Bound on the force [N].
        """
        return cls(UUID(goal), Goal(GripperCommand(position, force)))

    def serialize(self, *arguments, **flags) -> bytes:
        """Encodes the request, with the client's identity if there is one."""
        data = super().serialize(*arguments, **flags)
        return data[:_ENCAPSULATION] + self.client + data[_ENCAPSULATION:]

    @classmethod
    def deserialize(cls, data: bytes, *arguments, **flags) -> "GoalRequest":
        """Decodes a request with a client's identity."""
        end = _ENCAPSULATION + _HEADER
        rest = data[:_ENCAPSULATION] + data[end:]
        request = super().deserialize(rest, *arguments, **flags)
        request.client = data[_ENCAPSULATION:end]
        return request


@dc.dataclass
@final
class GoalInfo(IdlStruct, typename="action_msgs::msg::dds_::GoalInfo_"):
    """action_msgs/GoalInfo: a goal, and when it was accepted."""

    goal_id: UUID = dc.field(default_factory=UUID)
    stamp: Time = dc.field(default_factory=Time)


@dc.dataclass
@final
class GoalStatus(IdlStruct, typename="action_msgs::msg::dds_::GoalStatus_"):
    """action_msgs/GoalStatus: the state of a goal."""

    goal_info: GoalInfo = dc.field(default_factory=GoalInfo)
    status: int8 = 0


@dc.dataclass
@final
class GoalStatusArray(
    IdlStruct, typename="action_msgs::msg::dds_::GoalStatusArray_"
):
    """action_msgs/GoalStatusArray: the states of an action's goals."""

    status_list: sequence[GoalStatus] = dc.field(default_factory=list)
