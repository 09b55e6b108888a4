"""Defines MoveIt's messages as DDS types, in addition to `ros2_messages`.

The types are valid for ROS 2 since Humble. This module needs the optional extra
`ros2`.
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
    int8,
    sequence,
    uint8,
    uint32,
)

from remosplat_drake.hardware.drivers.ros2_messages import (
    ColorRGBA,
    Header,
    JointState,
    JointTrajectory,
    Point,
    Pose,
    Transform,
    TransformStamped,
    Twist,
    Vector3,
)


@dc.dataclass
@final
class Point32(IdlStruct, typename="geometry_msgs::msg::dds_::Point32_"):
    """geometry_msgs/Point32: a point [m]."""

    x: float32 = 0.0
    y: float32 = 0.0
    z: float32 = 0.0


@dc.dataclass
@final
class Polygon(IdlStruct, typename="geometry_msgs::msg::dds_::Polygon_"):
    """geometry_msgs/Polygon: the corners of a polygon."""

    points: sequence[Point32] = dc.field(default_factory=list)


@dc.dataclass
@final
class Wrench(IdlStruct, typename="geometry_msgs::msg::dds_::Wrench_"):
    """geometry_msgs/Wrench: a force and a torque [N, N m]."""

    force: Vector3 = dc.field(default_factory=Vector3)
    torque: Vector3 = dc.field(default_factory=Vector3)


@dc.dataclass
@final
class SolidPrimitive(
    IdlStruct, typename="shape_msgs::msg::dds_::SolidPrimitive_"
):
    """shape_msgs/SolidPrimitive: a solid, with its dimensions [m]."""

    type: uint8 = 0
    dimensions: sequence[float64, 3] = dc.field(default_factory=list)
    polygon: Polygon = dc.field(default_factory=Polygon)


@dc.dataclass
@final
class MeshTriangle(IdlStruct, typename="shape_msgs::msg::dds_::MeshTriangle_"):
    """shape_msgs/MeshTriangle: the corners of a triangle."""

    vertex_indices: array[uint32, 3] = dc.field(default_factory=lambda: [0] * 3)


@dc.dataclass
@final
class Mesh(IdlStruct, typename="shape_msgs::msg::dds_::Mesh_"):
    """shape_msgs/Mesh: triangles and their corners."""

    triangles: sequence[MeshTriangle] = dc.field(default_factory=list)
    vertices: sequence[Point] = dc.field(default_factory=list)


@dc.dataclass
@final
class Plane(IdlStruct, typename="shape_msgs::msg::dds_::Plane_"):
    """shape_msgs/Plane: a plane, given by its equation."""

    coef: array[float64, 4] = dc.field(default_factory=lambda: [0.0] * 4)


@dc.dataclass
@final
class ObjectType(
    IdlStruct, typename="object_recognition_msgs::msg::dds_::ObjectType_"
):
    """object_recognition_msgs/ObjectType: a kind of object in a database."""

    key: str = ""
    db: str = ""


@dc.dataclass
@final
class CollisionObject(
    IdlStruct, typename="moveit_msgs::msg::dds_::CollisionObject_"
):
    """moveit_msgs/CollisionObject: an object of a planning scene."""

    header: Header = dc.field(default_factory=Header)
    pose: Pose = dc.field(default_factory=Pose)
    id: str = ""
    type: ObjectType = dc.field(default_factory=ObjectType)
    primitives: sequence[SolidPrimitive] = dc.field(default_factory=list)
    primitive_poses: sequence[Pose] = dc.field(default_factory=list)
    meshes: sequence[Mesh] = dc.field(default_factory=list)
    mesh_poses: sequence[Pose] = dc.field(default_factory=list)
    planes: sequence[Plane] = dc.field(default_factory=list)
    plane_poses: sequence[Pose] = dc.field(default_factory=list)
    subframe_names: sequence[str] = dc.field(default_factory=list)
    subframe_poses: sequence[Pose] = dc.field(default_factory=list)
    operation: uint8 = 0


@dc.dataclass
@final
class AttachedCollisionObject(
    IdlStruct, typename="moveit_msgs::msg::dds_::AttachedCollisionObject_"
):
    """moveit_msgs/AttachedCollisionObject: an object that a link carries."""

    link_name: str = ""
    object: CollisionObject = dc.field(default_factory=CollisionObject)
    touch_links: sequence[str] = dc.field(default_factory=list)
    detach_posture: JointTrajectory = dc.field(default_factory=JointTrajectory)
    weight: float64 = 0.0


@dc.dataclass
@final
class MultiDOFJointState(
    IdlStruct, typename="sensor_msgs::msg::dds_::MultiDOFJointState_"
):
    """sensor_msgs/MultiDOFJointState: joints with several DOF."""

    header: Header = dc.field(default_factory=Header)
    joint_names: sequence[str] = dc.field(default_factory=list)
    transforms: sequence[Transform] = dc.field(default_factory=list)
    twist: sequence[Twist] = dc.field(default_factory=list)
    wrench: sequence[Wrench] = dc.field(default_factory=list)


@dc.dataclass
@final
class RobotState(IdlStruct, typename="moveit_msgs::msg::dds_::RobotState_"):
    """moveit_msgs/RobotState: a robot's joints and attached objects."""

    joint_state: JointState = dc.field(default_factory=JointState)
    multi_dof_joint_state: MultiDOFJointState = dc.field(
        default_factory=MultiDOFJointState
    )
    attached_collision_objects: sequence[AttachedCollisionObject] = dc.field(
        default_factory=list
    )
    is_diff: bool = False


@dc.dataclass
@final
class AllowedCollisionEntry(
    IdlStruct, typename="moveit_msgs::msg::dds_::AllowedCollisionEntry_"
):
    """moveit_msgs/AllowedCollisionEntry: a row of allowed collisions."""

    enabled: sequence[bool] = dc.field(default_factory=list)


@dc.dataclass
@final
class AllowedCollisionMatrix(
    IdlStruct, typename="moveit_msgs::msg::dds_::AllowedCollisionMatrix_"
):
    """moveit_msgs/AllowedCollisionMatrix: which pairs may touch."""

    entry_names: sequence[str] = dc.field(default_factory=list)
    entry_values: sequence[AllowedCollisionEntry] = dc.field(
        default_factory=list
    )
    default_entry_names: sequence[str] = dc.field(default_factory=list)
    default_entry_values: sequence[bool] = dc.field(default_factory=list)


@dc.dataclass
@final
class LinkPadding(IdlStruct, typename="moveit_msgs::msg::dds_::LinkPadding_"):
    """moveit_msgs/LinkPadding: the padding of a link [m]."""

    link_name: str = ""
    padding: float64 = 0.0


@dc.dataclass
@final
class LinkScale(IdlStruct, typename="moveit_msgs::msg::dds_::LinkScale_"):
    """moveit_msgs/LinkScale: the scale of a link."""

    link_name: str = ""
    scale: float64 = 0.0


@dc.dataclass
@final
class ObjectColor(IdlStruct, typename="moveit_msgs::msg::dds_::ObjectColor_"):
    """moveit_msgs/ObjectColor: the colour of an object."""

    id: str = ""
    color: ColorRGBA = dc.field(default_factory=ColorRGBA)


@dc.dataclass
@final
class Octomap(IdlStruct, typename="octomap_msgs::msg::dds_::Octomap_"):
    """octomap_msgs/Octomap: a map of cubes."""

    header: Header = dc.field(default_factory=Header)
    binary: bool = False
    id: str = ""
    resolution: float64 = 0.0
    data: sequence[int8] = dc.field(default_factory=list)


@dc.dataclass
@final
class OctomapWithPose(
    IdlStruct, typename="octomap_msgs::msg::dds_::OctomapWithPose_"
):
    """octomap_msgs/OctomapWithPose: a map of cubes in a frame."""

    header: Header = dc.field(default_factory=Header)
    origin: Pose = dc.field(default_factory=Pose)
    octomap: Octomap = dc.field(default_factory=Octomap)


@dc.dataclass
@final
class PlanningSceneWorld(
    IdlStruct, typename="moveit_msgs::msg::dds_::PlanningSceneWorld_"
):
    """moveit_msgs/PlanningSceneWorld: the objects of a scene."""

    collision_objects: sequence[CollisionObject] = dc.field(
        default_factory=list
    )
    octomap: OctomapWithPose = dc.field(default_factory=OctomapWithPose)


@dc.dataclass
@final
class PlanningScene(
    IdlStruct, typename="moveit_msgs::msg::dds_::PlanningScene_"
):
    """moveit_msgs/PlanningScene: a robot among objects."""

    name: str = ""
    robot_state: RobotState = dc.field(default_factory=RobotState)
    robot_model_name: str = ""
    fixed_frame_transforms: sequence[TransformStamped] = dc.field(
        default_factory=list
    )
    allowed_collision_matrix: AllowedCollisionMatrix = dc.field(
        default_factory=AllowedCollisionMatrix
    )
    link_padding: sequence[LinkPadding] = dc.field(default_factory=list)
    link_scale: sequence[LinkScale] = dc.field(default_factory=list)
    object_colors: sequence[ObjectColor] = dc.field(default_factory=list)
    world: PlanningSceneWorld = dc.field(default_factory=PlanningSceneWorld)
    is_diff: bool = False
