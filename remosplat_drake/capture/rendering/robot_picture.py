"""Renders a picture of a robot, next to a picture of its spheres."""

import colorsys

import numpy as np
from pydrake.geometry import (
    LightParameter,
    RenderEngineVtkParams,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.renderer import SceneRenderer
from remosplat_drake.capture.rendering.scene_files import solids_of
from remosplat_drake.capture.rendering.solids import Solid, painted
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres

SIZE = 560
"""Width and height of each of the two pictures [pixels]."""

_FIELD = 0.6
"""Vertical field of view [rad]."""

_FILLED = 0.9
"""Fraction of the field of view that the robot occupies."""

_DIRECTION = np.array([1.0, -1.15, 0.55])
"""Direction from the robot to the camera."""

_GREY = (0.75, 0.76, 0.78, 1.0)


def draw_robot(robot: RobotModel, q: np.ndarray) -> np.ndarray:
    """Draws a robot, and next to it the same view with the robot's spheres.

    Args:
        robot: The robot.
        q: Configuration of the robot, shape (n_q,) [rad, m].

    Returns:
        The picture, shape (SIZE, 2 SIZE, 3), uint8.

    Raises:
        MissingLibraryError: A library that rendering needs is not installed.
    """
    links = _link_solids(robot, q)
    spheres = _sphere_solids(robot, q)
    X_WC = framing(robot.spheres_at(q))
    pictures = [
        SceneRenderer(solids, SIZE, SIZE, _FIELD, _light()).color(X_WC)
        for solids in (links, spheres)
    ]
    return np.concatenate(pictures, axis=1)


def framing(spheres: Spheres) -> RigidTransform:
    """Computes the camera pose X_WC at which spheres fill the picture.

    In the camera's axes, let a sphere of radius r be at (x, y, z), and the
    camera at (x_C, y_C, -d). With half the field of view h, the sphere is
    inside the left and right sides of the view if

        |x - x_C| + r / cos(h) <= (z + d) tan(h),

    which is linear in x_C and d. The same holds for y.

    Args:
        spheres: The spheres, at least one.
    """
    R_WC = look_at(_DIRECTION, np.zeros(3)).rotation()
    p_CS = spheres.p_WS @ R_WC.matrix()
    half = 0.5 * _FIELD * _FILLED
    reach = spheres.radius[:, None] / np.cos(half)
    ahead = p_CS[:, 2:] * np.tan(half)
    upper = (p_CS[:, :2] + reach - ahead).max(axis=0)
    lower = (p_CS[:, :2] - reach + ahead).min(axis=0)
    away = 0.5 * (upper - lower).max() / np.tan(half)
    return RigidTransform(
        R_WC, R_WC @ np.array([*(0.5 * (upper + lower)), -away])
    )


def _light() -> RenderEngineVtkParams:
    lights = [
        LightParameter(
            type="directional", frame="world", direction=w, intensity=i
        )
        for w, i in (
            ([-0.5, 0.6, -1.0], 1.0),
            ([-1.0, 0.2, -0.1], 0.35),
            ([0.3, 1.0, 0.2], 0.25),
        )
    ]
    return RenderEngineVtkParams(
        lights=lights, default_clear_color=[0.97, 0.97, 0.98]
    )


def _link_solids(robot: RobotModel, q: np.ndarray) -> list[Solid]:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    add_robot_model(robot.description, plant)
    inspector = scene_graph.model_inspector()
    for i in range(plant.num_bodies()):
        body = plant.get_body(BodyIndex(i))
        if plant.GetVisualGeometriesForBody(body):
            continue
        shapes = plant.GetCollisionGeometriesForBody(body)
        for k, geometry in enumerate(shapes):
            plant.RegisterVisualGeometry(
                body,
                inspector.GetPoseInFrame(geometry),
                inspector.GetShape(geometry),
                f"shape_{k}",
                np.array(_GREY),
            )
    plant.Finalize()
    context = builder.Build().CreateDefaultContext()
    # The systems are valid only as long as the diagram's root exists.
    own = plant.GetMyMutableContextFromRoot(context)
    for name, value in (
        *zip(robot.joint_names, q, strict=True),
        *robot.description.locked.items(),
    ):
        joint = plant.GetJointByName(name)
        positions = plant.GetPositions(own)
        positions[joint.position_start()] = value
        plant.SetPositions(own, positions)
    query = scene_graph.get_query_output_port().Eval(
        scene_graph.GetMyContextFromRoot(context)
    )
    return list(solids_of(query))


def _sphere_solids(robot: RobotModel, q: np.ndarray) -> list[Solid]:
    """The spheres as solids; the spheres of each link have a common colour."""
    placed = robot.spheres_at(q)
    links = list(dict.fromkeys(robot.spheres.links))
    solids = []
    for link, p_WS, radius in zip(
        robot.spheres.links, placed.p_WS, placed.radius, strict=True
    ):
        hue = (0.58 + 0.381966 * links.index(link)) % 1.0
        rgb = colorsys.hsv_to_rgb(hue, 0.45, 0.92)
        look = painted((*rgb, 1.0))
        solids.append(Solid(RigidTransform(p_WS), Sphere(radius), look))
    return solids
