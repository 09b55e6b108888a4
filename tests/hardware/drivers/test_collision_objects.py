"""MoveIt's planning scenes: read by another decoder, and by a scenario."""

import math
import os
import threading
import time

import numpy as np
import pytest
import yaml
from patience import PATIENCE
from robot_process import running

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.hardware.drivers.collision_objects import CollisionObjects
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
typesys = pytest.importorskip("rosbags.typesys")

from remosplat_drake.hardware.drivers import moveit_messages as moveit
from remosplat_drake.hardware.drivers import ros2_messages as ros

DOMAIN = 89
BOX, SPHERE, CYLINDER = 1, 2, 3
ADD, REMOVE, APPEND, MOVE = 0, 1, 2, 3

DEFINITIONS = {
    "object_recognition_msgs/msg/ObjectType": "string key\nstring db",
    "moveit_msgs/msg/CollisionObject": """
        std_msgs/Header header
        geometry_msgs/Pose pose
        string id
        object_recognition_msgs/ObjectType type
        shape_msgs/SolidPrimitive[] primitives
        geometry_msgs/Pose[] primitive_poses
        shape_msgs/Mesh[] meshes
        geometry_msgs/Pose[] mesh_poses
        shape_msgs/Plane[] planes
        geometry_msgs/Pose[] plane_poses
        string[] subframe_names
        geometry_msgs/Pose[] subframe_poses
        byte operation""",
    "moveit_msgs/msg/AttachedCollisionObject": """
        string link_name
        moveit_msgs/CollisionObject object
        string[] touch_links
        trajectory_msgs/JointTrajectory detach_posture
        float64 weight""",
    "moveit_msgs/msg/RobotState": """
        sensor_msgs/JointState joint_state
        sensor_msgs/MultiDOFJointState multi_dof_joint_state
        moveit_msgs/AttachedCollisionObject[] attached_collision_objects
        bool is_diff""",
    "moveit_msgs/msg/AllowedCollisionEntry": "bool[] enabled",
    "moveit_msgs/msg/AllowedCollisionMatrix": """
        string[] entry_names
        moveit_msgs/AllowedCollisionEntry[] entry_values
        string[] default_entry_names
        bool[] default_entry_values""",
    "moveit_msgs/msg/LinkPadding": "string link_name\nfloat64 padding",
    "moveit_msgs/msg/LinkScale": "string link_name\nfloat64 scale",
    "moveit_msgs/msg/ObjectColor": "string id\nstd_msgs/ColorRGBA color",
    "octomap_msgs/msg/Octomap": """
        std_msgs/Header header
        bool binary
        string id
        float64 resolution
        int8[] data""",
    "octomap_msgs/msg/OctomapWithPose": """
        std_msgs/Header header
        geometry_msgs/Pose origin
        octomap_msgs/Octomap octomap""",
    "moveit_msgs/msg/PlanningSceneWorld": """
        moveit_msgs/CollisionObject[] collision_objects
        octomap_msgs/OctomapWithPose octomap""",
    "moveit_msgs/msg/PlanningScene": """
        string name
        moveit_msgs/RobotState robot_state
        string robot_model_name
        geometry_msgs/TransformStamped[] fixed_frame_transforms
        moveit_msgs/AllowedCollisionMatrix allowed_collision_matrix
        moveit_msgs/LinkPadding[] link_padding
        moveit_msgs/LinkScale[] link_scale
        moveit_msgs/ObjectColor[] object_colors
        moveit_msgs/PlanningSceneWorld world
        bool is_diff""",
}
"""The definitions of moveit_msgs from ROS 2 Humble on, which rosbags lacks."""


def pose(x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> ros.Pose:
    turned = ros.Quaternion(0, 0, math.sin(yaw / 2), math.cos(yaw / 2))
    return ros.Pose(ros.Point(x, y, 0.5), turned)


def thing(name: str, *solids, operation: int = ADD, frame: str = "world"):
    """An object at x = 1 m, turned by 90 degrees, with solids at its x = y."""
    return moveit.CollisionObject(
        header=ros.Header(frame_id=frame),
        id=name,
        pose=pose(1.0, yaw=math.pi / 2),
        primitives=[moveit.SolidPrimitive(k, list(d)) for k, d in solids],
        primitive_poses=[
            ros.Pose(ros.Point(0.1 * i, 0.0, 0.0)) for i in range(len(solids))
        ],
        operation=operation,
    )


CAN = CYLINDER, (0.16, 0.03)
BRICK = BOX, (0.2, 0.1, 0.05)


def scene(*things, is_diff: bool = True) -> moveit.PlanningScene:
    world = moveit.PlanningSceneWorld(list(things))
    return moveit.PlanningScene(name="lab", world=world, is_diff=is_diff)


def test_a_scene_is_read_by_another_decoder_and_back():
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    for name, text in DEFINITIONS.items():
        store.register(typesys.get_types_from_msg(text, name))
    message = scene(thing("can", CAN, BRICK), thing("", operation=REMOVE))
    attached = moveit.AttachedCollisionObject("hand", thing("cup", CAN), ["a"])
    attached.weight = 0.25
    message.robot_state.attached_collision_objects = [attached]
    message.robot_state.is_diff = True
    message.world.collision_objects[0].meshes = [
        moveit.Mesh([moveit.MeshTriangle([0, 1, 2])], [ros.Point(1, 2, 3)] * 3)
    ]
    matrix = message.allowed_collision_matrix
    matrix.entry_names = ["a"]
    matrix.entry_values = [moveit.AllowedCollisionEntry([True])]
    message.link_padding = [moveit.LinkPadding("a", 0.01)]
    message.object_colors = [moveit.ObjectColor("can")]
    message.world.octomap.octomap.data = [-1, 1]
    data, name = message.serialize(), "moveit_msgs/msg/PlanningScene"
    read = store.deserialize_cdr(data, name)
    assert read.is_diff
    can = read.world.collision_objects[0]
    assert (can.id, list(can.primitives[1].dimensions)) == (
        "can",
        [0.2, 0.1, 0.05],
    )
    again = bytes(store.serialize_cdr(read, name))
    assert again == data
    assert moveit.PlanningScene.deserialize(again) == message


def test_shapes_are_placed_as_their_object_is():
    objects = CollisionObjects("world")
    assert objects.put_scene(scene(thing("can", CAN, BRICK))) == []
    can, brick = objects.entries()
    assert can["cylinder"] == {"radius": 0.03, "height": 0.16}
    assert brick["box"] == [0.2, 0.1, 0.05]
    assert (can["name"], brick["name"]) == ("can 1", "can 2")
    assert brick["X_WO"]["translation"] == [1.0, 0.1, 0.5]
    np.testing.assert_allclose(
        brick["X_WO"]["rotation"], [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    )
    text = yaml.safe_dump({"objects": objects.entries()})
    first, second = load_scenario("TableReach", text).objects
    assert first.cylinder is not None and first.cylinder.height == 0.16
    assert (second.box, second.in_splat) == ([0.2, 0.1, 0.05], False)


def test_objects_are_moved_appended_and_removed():
    objects = CollisionObjects("/world")
    objects.put(thing("can", CAN))
    moved = thing("can", operation=MOVE)
    moved.pose = pose(2.0)
    objects.put(moved)
    (can,) = objects.entries()
    assert can["X_WO"]["translation"] == [2.0, 0.0, 0.5]
    objects.put(thing("can", BRICK, operation=APPEND))
    _, brick = objects.entries()
    assert brick["X_WO"]["translation"] == [1.0, 0.0, 0.5]
    objects.put(thing("wall", BRICK))
    objects.put(thing("can", operation=REMOVE))
    assert [entry["name"] for entry in objects.entries()] == ["wall"]
    objects.put_scene(scene(thing("floor", BRICK), is_diff=False))
    assert [entry["name"] for entry in objects.entries()] == ["floor"]
    objects.put(thing("", operation=REMOVE))
    assert objects.entries() == []


def test_what_cannot_be_used_is_refused_by_its_name():
    mesh = thing("mug")
    mesh.meshes = [moveit.Mesh()]
    lost = thing("lost", BRICK)
    lost.pose.position.x = math.nan
    cases = {
        "object 'mug' is left out: it has meshes; give boxes": mesh,
        "object 'ball' is left out: it is a sphere": thing(
            "ball", (SPHERE, (0.1,))
        ),
        "object 'odd' is left out: its box has the dimensions [0.1": thing(
            "odd", (BOX, (0.1, 0.2))
        ),
        "object 'far' is left out: frame_id is 'map', not 'world'": thing(
            "far", BRICK, frame="map"
        ),
        "object 'lost' is left out: its pose has a number": lost,
    }
    objects = CollisionObjects("world")
    found = objects.put_scene(scene(*cases.values(), thing("can", CAN)))
    for problem, start in zip(found, cases, strict=True):
        assert problem.startswith(start)
    assert [entry["name"] for entry in objects.entries()] == ["can"]


@pytest.mark.slow
def test_a_process_writes_the_objects_that_come(tmp_path):
    out, own = tmp_path / "objects.yaml", dict(os.environ)
    own["ROS_DOMAIN_ID"] = str(DOMAIN)
    node = Ros2Node(DOMAIN, "a test")
    scenes = node.writer("/planning_scene", moveit.PlanningScene)
    single = node.writer("/collision_object", moveit.CollisionObject)
    line = ("ros2-objects", "--out", str(out), "--duration", "600")
    said: list[str] = []
    with running(*line, environment=own) as process:
        listener = threading.Thread(target=said.extend, args=[process.stderr])
        listener.start()
        end = time.monotonic() + PATIENCE
        # What is refused is told: so all that was sent with it has come, too.
        while not all(name in "".join(said) for name in ("'ball'", "'egg'")):
            assert time.monotonic() < end
            assert process.poll() is None, said
            single.write(thing("wall", BRICK))
            single.write(thing("ball", (SPHERE, (0.1,))))
            scenes.write(scene(thing("can", CAN), thing("egg", (SPHERE, (1,)))))
            time.sleep(0.02)
        process.terminate()
        assert process.wait(PATIENCE) == 1
        listener.join()
    names = [x["name"] for x in yaml.safe_load(out.read_text())["objects"]]
    assert sorted(names) == ["can", "wall"]
