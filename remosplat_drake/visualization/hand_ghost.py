"""`HandGhost`: draws a translucent hand at its target."""

import json
from pathlib import Path

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh, Rgba, Shape

from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.target import Target
from remosplat_drake.visualization.drawn_plant import drawn_plant
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.shapes import rigid_transform

NEAR, TURNED = 0.03, 0.15
"""The ghost is hidden if the hand's distance [m] and angle [rad] from the
target are both below these values."""

_COLOR = Rgba(0.10, 0.62, 0.52, 0.45)


class HandGhost:
    """Draws a ghost: the links of a hand, at the pose of its target.

    If the target has free directions, the ghost has the permitted pose that is
    nearest to the end effector's present pose.

    Args:
        page: The page to draw on.
        path: Path in the scene tree below which the ghost is drawn.
        robot: The robot.
        effector: Index of the end effector whose hand is drawn.
    """

    def __init__(
        self, page: MeshcatPage, path: str, robot: RobotModel, effector: int
    ):
        self._scene, self._path = page.scene, path
        self._is_shown = False
        drawn = drawn_plant(robot)
        X_WL = robot.body_poses(robot.q_home)
        X_EW = np.linalg.inv(robot.end_effector_pose(robot.q_home, effector))
        for link in sorted(hand_links(robot, effector)):
            X_EL = X_EW @ X_WL[robot.tree.index(link)]
            for i, look in enumerate(
                drawn.looks(drawn.plant.GetBodyByName(link))
            ):
                name = f"{path}/{link}/{i}"
                page.meshcat.SetObject(name, translucent(look.shape), _COLOR)
                X_EG = rigid_transform(X_EL).multiply(look.X_LG)
                page.meshcat.SetTransform(name, X_EG)
        self._scene.set_property(path, "visible", False)

    def update(self, target: Target, X_WE: np.ndarray | None, time: float):
        """Moves the ghost to a target; hides it if the hand is at the target.

        Args:
            target: The target.
            X_WE: Pose of the end effector, shape (4, 4); None before it is
                measured.
            time: Time in a recording [s].
        """
        is_shown = target.is_known and (X_WE is None or is_away(target, X_WE))
        if is_shown:
            X_WT = target.X_WT if X_WE is None else target.nearest_pose(X_WE)
            self._scene.move(self._path, rigid_transform(X_WT), time)
        if is_shown != self._is_shown:
            self._is_shown = is_shown
            self._scene.show(self._path, is_shown, time)


def is_away(target: Target, X_WE: np.ndarray) -> bool:
    """Returns whether a hand is so far from a target that a ghost is drawn.

    Args:
        target: The target.
        X_WE: Pose of the end effector, shape (4, 4).
    """
    error = target.error(X_WE)
    return error.distance > NEAR or error.angle > TURNED


def translucent(shape: Shape) -> Shape:
    """Returns a translucent copy of a shape.

    Args:
        shape: The shape. A shape without materials is returned unchanged, since
            its colour is set when it is drawn.
    """
    if not isinstance(shape, Mesh) or shape.extension() != ".gltf":
        return shape
    document = json.loads(Path(shape.source().path()).read_text("utf-8"))
    color = [_COLOR.r(), _COLOR.g(), _COLOR.b(), _COLOR.a()]
    for material in document.get("materials", ()):
        material["pbrMetallicRoughness"] = {
            "baseColorFactor": color,
            "metallicFactor": 0.1,
            "roughnessFactor": 0.6,
        }
        material["alphaMode"] = "BLEND"
    file = MemoryFile(json.dumps(document), ".gltf", "ghost")
    return Mesh(InMemoryMesh(mesh_file=file), shape.scale3())
