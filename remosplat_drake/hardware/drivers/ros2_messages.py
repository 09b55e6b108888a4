"""Defines ROS 2's messages as DDS types, with ROS's names for them in DDS.

In DDS, the type `geometry_msgs/msg/Twist` is called
`geometry_msgs::msg::dds_::Twist_`, and the topic `/cmd_vel` is `rt/cmd_vel`.
The module needs the package cyclonedds (optional extra `ros2`), but no ROS
installation.
"""

# The package annotates neither its class arguments nor its array lengths.
# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import dataclasses as dc

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import (
    array,
    float32,
    float64,
    int32,
    sequence,
    uint8,
    uint32,
)


def dds_topic(topic: str) -> str:
    """Returns the DDS name of a ROS 2 topic: `rt/cmd_vel` for `/cmd_vel`."""
    return f"rt/{topic.strip('/')}"


def request_topic(service: str) -> str:
    """Returns the DDS name of a service's requests: `rq/addRequest` for `/add`.

    Args:
        service: ROS 2's name of the service.
    """
    return f"rq/{service.strip('/')}Request"


def _zeros36() -> list[float]:
    return [0.0] * 36


@dc.dataclass
@final
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    """builtin_interfaces/Time: seconds and nanoseconds of the Unix epoch."""

    sec: int32 = 0
    nanosec: uint32 = 0


def stamp(utime: int) -> Time:
    """Converts a time in microseconds of the Unix epoch to ROS's type."""
    return Time(utime // 1_000_000, 1000 * (utime % 1_000_000))


@dc.dataclass
@final
class Duration(IdlStruct, typename="builtin_interfaces::msg::dds_::Duration_"):
    """builtin_interfaces/Duration: seconds and nanoseconds."""

    sec: int32 = 0
    nanosec: uint32 = 0


@dc.dataclass
@final
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    """std_msgs/Header: time and frame of a measurement."""

    stamp: Time = dc.field(default_factory=Time)
    frame_id: str = ""


@dc.dataclass
@final
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    """geometry_msgs/Vector3: a vector."""

    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dc.dataclass
@final
class Twist(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    """geometry_msgs/Twist: linear and angular velocity [m/s, rad/s]."""

    linear: Vector3 = dc.field(default_factory=Vector3)
    angular: Vector3 = dc.field(default_factory=Vector3)


@dc.dataclass
@final
class TwistStamped(
    IdlStruct, typename="geometry_msgs::msg::dds_::TwistStamped_"
):
    """geometry_msgs/TwistStamped: a velocity, and the time of its command."""

    header: Header = dc.field(default_factory=Header)
    twist: Twist = dc.field(default_factory=Twist)


@dc.dataclass
@final
class Point(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    """geometry_msgs/Point: a position [m]."""

    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dc.dataclass
@final
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    """geometry_msgs/Quaternion: a rotation."""

    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0
    w: float64 = 1.0


@dc.dataclass
@final
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    """geometry_msgs/Pose: a position and a rotation."""

    position: Point = dc.field(default_factory=Point)
    orientation: Quaternion = dc.field(default_factory=Quaternion)


@dc.dataclass
@final
class PoseWithCovariance(
    IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovariance_"
):
    """geometry_msgs/PoseWithCovariance: a pose and its 6x6 covariance."""

    pose: Pose = dc.field(default_factory=Pose)
    covariance: array[float64, 36] = dc.field(default_factory=_zeros36)


@dc.dataclass
@final
class TwistWithCovariance(
    IdlStruct, typename="geometry_msgs::msg::dds_::TwistWithCovariance_"
):
    """geometry_msgs/TwistWithCovariance: a velocity and its covariance."""

    twist: Twist = dc.field(default_factory=Twist)
    covariance: array[float64, 36] = dc.field(default_factory=_zeros36)


@dc.dataclass
@final
class Odometry(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    """nav_msgs/Odometry: pose and velocity of a base."""

    header: Header = dc.field(default_factory=Header)
    child_frame_id: str = ""
    pose: PoseWithCovariance = dc.field(default_factory=PoseWithCovariance)
    twist: TwistWithCovariance = dc.field(default_factory=TwistWithCovariance)


@dc.dataclass
@final
class PoseWithCovarianceStamped(
    IdlStruct,
    typename="geometry_msgs::msg::dds_::PoseWithCovarianceStamped_",
):
    """geometry_msgs/PoseWithCovarianceStamped: a localised pose."""

    header: Header = dc.field(default_factory=Header)
    pose: PoseWithCovariance = dc.field(default_factory=PoseWithCovariance)


@dc.dataclass
@final
class Transform(IdlStruct, typename="geometry_msgs::msg::dds_::Transform_"):
    """geometry_msgs/Transform: a translation and a rotation."""

    translation: Vector3 = dc.field(default_factory=Vector3)
    rotation: Quaternion = dc.field(default_factory=Quaternion)


@dc.dataclass
@final
class TransformStamped(
    IdlStruct, typename="geometry_msgs::msg::dds_::TransformStamped_"
):
    """geometry_msgs/TransformStamped: pose of a frame in another."""

    header: Header = dc.field(default_factory=Header)
    child_frame_id: str = ""
    transform: Transform = dc.field(default_factory=Transform)


@dc.dataclass
@final
class TFMessage(IdlStruct, typename="tf2_msgs::msg::dds_::TFMessage_"):
    """tf2_msgs/TFMessage: the messages of /tf."""

    transforms: sequence[TransformStamped] = dc.field(default_factory=list)


@dc.dataclass
@final
class Bool(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    """std_msgs/Bool: true or false."""

    data: bool = False


@dc.dataclass
@final
class Int32(IdlStruct, typename="std_msgs::msg::dds_::Int32_"):
    """std_msgs/Int32: a whole number."""

    data: int32 = 0


@dc.dataclass
@final
class String(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    """std_msgs/String: a text."""

    data: str = ""


@dc.dataclass
@final
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    """sensor_msgs/JointState: positions and rates of joints."""

    header: Header = dc.field(default_factory=Header)
    name: sequence[str] = dc.field(default_factory=list)
    position: sequence[float64] = dc.field(default_factory=list)
    velocity: sequence[float64] = dc.field(default_factory=list)
    effort: sequence[float64] = dc.field(default_factory=list)


@dc.dataclass
@final
class MultiArrayDimension(
    IdlStruct, typename="std_msgs::msg::dds_::MultiArrayDimension_"
):
    """std_msgs/MultiArrayDimension: one dimension of an array."""

    label: str = ""
    size: uint32 = 0
    stride: uint32 = 0


@dc.dataclass
@final
class MultiArrayLayout(
    IdlStruct, typename="std_msgs::msg::dds_::MultiArrayLayout_"
):
    """std_msgs/MultiArrayLayout: layout of an array."""

    dim: sequence[MultiArrayDimension] = dc.field(default_factory=list)
    data_offset: uint32 = 0


@dc.dataclass
@final
class Float64MultiArray(
    IdlStruct, typename="std_msgs::msg::dds_::Float64MultiArray_"
):
    """std_msgs/Float64MultiArray: numbers, such as joint rates."""

    layout: MultiArrayLayout = dc.field(default_factory=MultiArrayLayout)
    data: sequence[float64] = dc.field(default_factory=list)


@dc.dataclass
@final
class JointTrajectoryPoint(
    IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectoryPoint_"
):
    """trajectory_msgs/JointTrajectoryPoint: state of joints at a time."""

    positions: sequence[float64] = dc.field(default_factory=list)
    velocities: sequence[float64] = dc.field(default_factory=list)
    accelerations: sequence[float64] = dc.field(default_factory=list)
    effort: sequence[float64] = dc.field(default_factory=list)
    time_from_start: Duration = dc.field(default_factory=Duration)


@dc.dataclass
@final
class JointTrajectory(
    IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectory_"
):
    """trajectory_msgs/JointTrajectory: a motion of some joints."""

    header: Header = dc.field(default_factory=Header)
    joint_names: sequence[str] = dc.field(default_factory=list)
    points: sequence[JointTrajectoryPoint] = dc.field(default_factory=list)


@dc.dataclass
@final
class GripperCommand(
    IdlStruct, typename="control_msgs::msg::dds_::GripperCommand_"
):
    """control_msgs/GripperCommand: a gripper's position [m] and force [N]."""

    position: float64 = 0.0
    max_effort: float64 = 0.0


@dc.dataclass
@final
class PoseStamped(IdlStruct, typename="geometry_msgs::msg::dds_::PoseStamped_"):
    """geometry_msgs/PoseStamped: a pose in a frame, and its time."""

    header: Header = dc.field(default_factory=Header)
    pose: Pose = dc.field(default_factory=Pose)


@dc.dataclass
@final
class ColorRGBA(IdlStruct, typename="std_msgs::msg::dds_::ColorRGBA_"):
    """std_msgs/ColorRGBA: a colour, each part from 0 to 1."""

    r: float32 = 0.0
    g: float32 = 0.0
    b: float32 = 0.0
    a: float32 = 1.0


@dc.dataclass
@final
class CompressedImage(
    IdlStruct, typename="sensor_msgs::msg::dds_::CompressedImage_"
):
    """sensor_msgs/CompressedImage: an encoded image."""

    header: Header = dc.field(default_factory=Header)
    format: str = ""
    data: sequence[uint8] = dc.field(default_factory=list)


@dc.dataclass
@final
class UVCoordinate(
    IdlStruct, typename="visualization_msgs::msg::dds_::UVCoordinate_"
):
    """visualization_msgs/UVCoordinate: a position in a texture."""

    u: float32 = 0.0
    v: float32 = 0.0


@dc.dataclass
@final
class MeshFile(IdlStruct, typename="visualization_msgs::msg::dds_::MeshFile_"):
    """visualization_msgs/MeshFile: a mesh inside a message."""

    filename: str = ""
    data: sequence[uint8] = dc.field(default_factory=list)


@dc.dataclass
@final
class Marker(IdlStruct, typename="visualization_msgs::msg::dds_::Marker_"):
    """visualization_msgs/Marker (since Humble): a shape for RViz."""

    header: Header = dc.field(default_factory=Header)
    ns: str = ""
    id: int32 = 0
    type: int32 = 0
    action: int32 = 0
    pose: Pose = dc.field(default_factory=Pose)
    scale: Vector3 = dc.field(default_factory=Vector3)
    color: ColorRGBA = dc.field(default_factory=ColorRGBA)
    lifetime: Duration = dc.field(default_factory=Duration)
    frame_locked: bool = False
    points: sequence[Point] = dc.field(default_factory=list)
    colors: sequence[ColorRGBA] = dc.field(default_factory=list)
    texture_resource: str = ""
    texture: CompressedImage = dc.field(default_factory=CompressedImage)
    uv_coordinates: sequence[UVCoordinate] = dc.field(default_factory=list)
    text: str = ""
    mesh_resource: str = ""
    mesh_file: MeshFile = dc.field(default_factory=MeshFile)
    mesh_use_embedded_materials: bool = False


@dc.dataclass
@final
class MarkerArray(
    IdlStruct, typename="visualization_msgs::msg::dds_::MarkerArray_"
):
    """visualization_msgs/MarkerArray: shapes for RViz."""

    markers: sequence[Marker] = dc.field(default_factory=list)
