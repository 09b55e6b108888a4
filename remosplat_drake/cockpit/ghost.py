"""`Ghost`: the robot as it would stand at a target, coloured by its verdict."""

import numpy as np
import viser

from remosplat_drake.cockpit.reach import (
    BLOCKED,
    REACHABLE,
    UNSEEN_THERE,
    Reach,
)
from remosplat_drake.cockpit.robot_shapes import Shapes, wxyz_position
from remosplat_drake.robot.robot_model import RobotModel

COLOURS = {
    REACHABLE: (60, 180, 90),
    BLOCKED: (215, 50, 45),
    UNSEEN_THERE: (135, 95, 215),
}
"""Colours of the ghost by its verdict; out of reach there is none."""

_OPACITY = 0.4


class Ghost:
    """Draws a configuration for one client, its operator.

    Args:
        scene: The client's own scene.
        robot: The robot.
        shapes: The look of its links.
    """

    def __init__(
        self, scene: viser.SceneApi, robot: RobotModel, shapes: Shapes
    ):
        self._robot = robot
        self._links: dict[str, viser.MeshHandle] = {}
        for link, mesh in shapes.joined.items():
            self._links[link] = scene.add_mesh_simple(
                f"/ghost/{link}",
                mesh.vertices,
                mesh.faces,
                opacity=_OPACITY,
                cast_shadow=False,
                receive_shadow=False,
                visible=False,
            )

    def show(self, reach: Reach | None) -> None:
        """Draws the answer to whether a target can be reached.

        Args:
            reach: The answer; None, or one without a configuration, hides
                the ghost.
        """
        q = None if reach is None else reach.q
        if q is None or reach is None:
            for mesh in self._links.values():
                mesh.visible = False
            return
        X_WL = self._robot.body_poses(np.asarray(q))
        for name, mesh in self._links.items():
            X = X_WL[self._robot.tree.index(name)]
            mesh.wxyz, mesh.position = wxyz_position(X)
            mesh.color = COLOURS[reach.verdict]
            mesh.visible = True

    def remove(self) -> None:
        """Takes the ghost out of the scene."""
        for mesh in self._links.values():
            mesh.remove()
