"""A picture of a benchmark scene: the solids, the robot and its target."""

import dataclasses as dc

import numpy as np
from PIL import Image, ImageDraw
from pydrake.geometry import (
    LightParameter,
    RenderEngineVtkParams,
    SsaoParameter,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.renderer import SceneRenderer
from remosplat_drake.capture.rendering.scene_files import solids_of
from remosplat_drake.capture.rendering.solids import Solid, drake_shape, painted
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.station.robot_visuals import add_robot_visuals
from remosplat_drake.station.scene_geometry import (
    BOX_COLOUR,
    CYLINDER_COLOUR,
)

CAMERA_W, FOCUS_W = np.array([-1.5, -2.7, 2.6]), np.array([0.7, -0.12, 0.43])
"""Position of the camera and of the point it looks at in W: from behind the
robot's right [m]."""

FIELD_OF_VIEW = 0.6
"""Vertical field of view [rad]."""

BACKGROUND = (247, 248, 250)
_FLOOR_COLOUR = (0.93, 0.935, 0.945, 1.0)
_LIGHTS = (
    ([0.35, 0.35, -0.87], 2.2),
    ([0.8, 0.5, -0.1], 1.1),
    ([0.3, -0.9, -0.3], 0.5),
)
"""Directions in W in which light falls, and its intensity."""

_AXIS_COLOURS = ((222, 60, 52), (46, 160, 67), (40, 104, 220))
_AXIS_LENGTH = 0.14
"""Length of the axes of the target's frame [m]."""

_FINER = 2
"""Factor by which pictures are drawn larger before they are smoothed."""


def daylight() -> RenderEngineVtkParams:
    """Makes lights fixed in W, with darker corners and contacts."""
    return RenderEngineVtkParams(
        lights=[
            LightParameter(
                frame="world", direction=direction, intensity=intensity
            )
            for direction, intensity in _LIGHTS
        ],
        default_clear_color=np.array(BACKGROUND) / 255,
        # Otherwise the light would depend on the presence of meshes of the
        # robot.
        force_to_pbr=True,
        ssao=SsaoParameter(radius=0.25, sample_count=48),
    )


def robot_solids(robot: RobotModel) -> tuple[Solid, ...]:
    """Returns the robot's solids in its home configuration, its base at W."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    add_robot_model(robot.description, plant)
    add_robot_visuals(plant, scene_graph, robot)
    plant.Finalize()
    arm = robot.joint_names[robot.n_q - len(robot.home) :]
    positions = dict(zip(arm, robot.home, strict=True))
    for name, position in (positions | robot.description.locked).items():
        plant.GetJointByName(name).set_default_positions([position])
    context = builder.Build().CreateDefaultContext()
    query = scene_graph.get_query_output_port().Eval(
        scene_graph.GetMyContextFromRoot(context)
    )
    return tuple(solids_of(query))


@dc.dataclass(frozen=True)
class SceneView:
    """Draws scenes from one viewpoint.

    Attributes:
        robot: Solids of the robot, from `robot_solids`.
        width: Width of each picture [pixels].
        height: Height of each picture [pixels].
    """

    robot: tuple[Solid, ...]
    width: int = 480
    height: int = 360

    def draw(self, scene: PrimitiveScene) -> Image.Image:
        """Draws the scene with the robot at its start and the target's frame.

        The frame is drawn over everything: x red, y green, z blue.
        """
        solids = [*_scene_solids(scene), _floor()]
        if scene.X_WB_start is not None:
            x, y, yaw = scene.X_WB_start
            R_WB = RotationMatrix.MakeZRotation(yaw)
            X_WB = RigidTransform(R_WB, [x, y, 0.0])
            solids += [solid.moved(X_WB) for solid in self.robot]
        renderer = SceneRenderer(
            solids,
            _FINER * self.width,
            _FINER * self.height,
            FIELD_OF_VIEW,
            daylight(),
        )
        X_WC = look_at(CAMERA_W, FOCUS_W)
        picture = Image.fromarray(renderer.color(X_WC))
        if scene.X_WE_target is not None:
            _draw_frame(picture, renderer.K, X_WC.inverse() @ scene.X_WE_target)
        return picture.resize((self.width, self.height), Image.Resampling.BOX)


def _scene_solids(scene: PrimitiveScene) -> list[Solid]:
    return [
        Solid(
            primitive.X_WP,
            drake_shape(primitive),
            painted(
                BOX_COLOUR if isinstance(primitive, Box) else CYLINDER_COLOUR
            ),
        )
        for primitive in scene.primitives
    ]


def _floor() -> Solid:
    (floor,) = PrimitiveScene().with_floor((0.9, 0.0), 2.3).boxes
    return Solid(floor.X_WP, drake_shape(floor), painted(_FLOOR_COLOUR))


def _draw_frame(picture: Image.Image, K: np.ndarray, X_CE: RigidTransform):
    """Draws the axes of a frame E, those farther away first."""
    X = X_CE.GetAsMatrix4()
    tips = X[:3, 3] + _AXIS_LENGTH * X[:3, :3].T
    pixels = np.vstack([X[:3, 3], tips]) @ K.T
    pixels = pixels[:, :2] / pixels[:, 2:]
    canvas = ImageDraw.Draw(picture)
    origin = tuple(pixels[0])
    for axis in np.argsort(-tips[:, 2]):
        line = [origin, tuple(pixels[1 + axis])]
        canvas.line(line, fill="white", width=5 * _FINER)
        canvas.line(line, fill=_AXIS_COLOURS[axis], width=3 * _FINER)
    canvas.circle(origin, 3.5 * _FINER, fill="white")
    canvas.circle(origin, 2.5 * _FINER, fill=(30, 30, 30))
