"""Excludes contact between links that meet at a joint.

Collision shapes are coarser than links, and overlap where links meet. Drake
ignores such overlaps of a joint's two links, but not those of links that are
fixed to them, such as a flange behind a wrist. Contact between these links
would block the joint.
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
    """Ignores contact between links whose self-collision is not checked.

    These are the pairs that `possible_pairs` leaves out: links fewer than two
    moving joints apart, and those that the description or its SRDF allows to
    touch.

    Args:
        plant: The finalized plant with the robot.
        scene_graph: The scene graph with its geometry.
        robot: The robot.

    Raises:
        FileError: The SRDF file of its description cannot be read.
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
