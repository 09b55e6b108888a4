"""Excludes contact between links that meet at a joint.

Collision shapes are larger than links, and overlap where links meet. Drake
ignores overlaps of the two links of a joint, but not those of further links
that are fixed to these two, such as a flange behind a wrist. Contact between
such links would block the joint.
"""

from pydrake.geometry import (
    CollisionFilterDeclaration,
    GeometrySet,
    SceneGraph,
)
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.link_pairs import possible_pairs


def let_neighbours_overlap(
    plant: MultibodyPlant, scene_graph: SceneGraph, robot: RobotModel
) -> None:
    """Excludes contact between links whose self-collision is not checked.

    These are the pairs that `possible_pairs` omits: links with fewer than two
    moving joints between them, and links that the robot's description or its
    SRDF allows to touch.

    Args:
        plant: The finalized plant with the robot.
        scene_graph: The scene graph with its geometry.
        robot: The robot.

    Raises:
        FileError: The SRDF file of the robot's description cannot be read.
    """
    shapes = {}
    for name in robot.tree.names:
        if plant.HasBodyNamed(name):
            body = plant.GetBodyByName(name)
            shapes[name] = plant.GetCollisionGeometriesForBody(body)
    solid = [name for name, found in shapes.items() if found]
    _, left_out = possible_pairs(robot, solid)
    declaration = CollisionFilterDeclaration()
    for a, b in left_out:
        declaration.ExcludeBetween(
            GeometrySet(shapes[a]), GeometrySet(shapes[b])
        )
    scene_graph.collision_filter_manager().Apply(declaration)
