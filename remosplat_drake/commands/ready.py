"""Describes a run to the person who starts it: robot, targets, map error."""

import numpy as np
from pydrake.systems.framework import Context, OutputPort

from remosplat_drake.app.diagram import Application
from remosplat_drake.app.map_grade import wrong_by
from remosplat_drake.app.map_knowledge import MapKnowledge
from remosplat_drake.motion_status.names import name_thing
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.aim import Aim
from remosplat_drake.task.targets import target_port
from remosplat_drake.visualization.robot_view import draw_robot
from remosplat_drake.visualization.run_view import draw_targets

_NEAR = 0.25
"""The description names the object nearest to a target if their distance is
less than this [m]."""

_SMALL = 0.01
"""The description omits the offset to a target along an axis if it is below
this [m]."""


def show_start(application: Application) -> None:
    """Draws the robot at its start, and its targets.

    Args:
        application: The diagram, with a page.
    """
    draw_robot(application.diagram)
    aim = _first_aim(application, application.diagram.CreateDefaultContext())
    if aim is not None:
        draw_targets(application.diagram, aim)


def goal_in_words(application: Application, knowledge: MapKnowledge) -> str:
    """Describes the robot's task and the map's quality in a sentence.

    Args:
        application: The diagram.
        knowledge: Content, error and problems of the map.
    """
    root = application.diagram.CreateDefaultContext()
    aim = _first_aim(application, root)
    said = "it waits for a target"
    if aim is not None:
        q = np.array(_value(application.configuration, root))
        said = _way(aim, application.world.robot, q) + _beside(application, aim)
        count = application.targets.progress(
            application.targets.GetMyContextFromRoot(root)
        ).count
        if count > 1:
            said = f"{count} targets, the first: {said}"
    error = knowledge.error.largest
    if error is not None:
        said += f"; the map is {wrong_by(error)}"
    return said


def _first_aim(application: Application, root: Context) -> Aim | None:
    """Returns the robot's first target; None if it is still unknown."""
    aim = Aim.of(_value(target_port(application.targets), root))
    return aim if aim.is_known else None


def _value(port: OutputPort, root: Context):
    return port.Eval(port.get_system().GetMyContextFromRoot(root))


def _way(aim: Aim, robot: RobotModel, q: np.ndarray) -> str:
    """Describes the displacement to the target, along the base's axes."""
    effector, target = aim.items[0]
    p_EO_W = target.X_WT[:3, 3] - robot.end_effector_poses(q)[effector][:3, 3]
    if not target.constrains_position:
        return "turn the hand"
    x, y, z = robot.state(q).X_WB[:3, :3].T @ p_EO_W
    parts = [
        f"{abs(part):.2f} m {words[int(part < 0)]}"
        for part, words in (
            (x, ("ahead", "back")),
            (y, ("to the left", "to the right")),
            (z, ("up", "down")),
        )
        if abs(part) >= _SMALL
    ]
    hand = robot.effectors[effector]
    return f"reach {hand and f'with {hand} '}" + (
        ", ".join(parts) or "no further"
    )


def _beside(application: Application, aim: Aim) -> str:
    """Names the object nearest to the target, and its distance; "" if none."""
    world, p_WT = application.world, aim.first.X_WT[:3, 3]
    near = world.field.clearances(Spheres.at(p_WT), _NEAR)
    if not len(near) or not aim.first.constrains_position:
        return ""
    i = int(near.distance.argmin())
    floor = application.scenario.scene.floor_height
    truth = None if world.truth is None else SignedDistanceField(world.truth)
    thing = name_thing(world.field, near.p_WC[i], floor, truth)
    return f", {1e3 * near.distance[i]:.0f} mm from {thing.name}"
