"""`Ghost`: draws a target, and the robot's configuration that reaches it."""

import numpy as np
import viser

from remosplat_drake.cockpit.reach import (
    BLOCKED,
    OUT_OF_REACH,
    REACHABLE,
    UNSEEN_THERE,
    Reach,
)
from remosplat_drake.cockpit.robot_shapes import Shapes, wxyz_position
from remosplat_drake.robot.robot_model import RobotModel

COLOURS = {
    REACHABLE: (43, 138, 62),
    BLOCKED: (215, 50, 45),
    UNSEEN_THERE: (135, 95, 215),
    OUT_OF_REACH: (73, 80, 87),
}
"""Colours of the ghost, keyed by the verdict of `find_reach`. If the target is
out of reach, no ghost is drawn."""

_OPACITY = 0.4
_TARGET = 0.025
"""Radius of the target's mark [m]."""


class Ghost:
    """Draws a target, and the robot's configuration that reaches it.

    The drawn configuration (ghost) is translucent, and its colour shows whether
    the robot can reach the target.

    Args:
        scene: The scene of the client that operates the robot; other clients
            do not see the ghost.
        robot: The robot.
        shapes: The meshes of the robot's links.
    """

    def __init__(
        self, scene: viser.SceneApi, robot: RobotModel, shapes: Shapes
    ):
        self._robot = robot
        self._target = scene.add_icosphere(
            "/ghost/target",
            _TARGET,
            opacity=0.8,
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
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

    def show(self, reach: Reach, X_WT: np.ndarray) -> None:
        """Draws a target and the configuration that reaches it.

        Args:
            reach: Result of the search for a configuration. Its verdict
                determines the colour. If it has no configuration, only the
                target is drawn.
            X_WT: The target, shape (4, 4).
        """
        self._target.position = X_WT[:3, 3]
        self._target.color = COLOURS[reach.verdict]
        self._target.visible = True
        q = reach.q
        if q is None:
            self._hide_links()
            return
        X_WL = self._robot.body_poses(np.asarray(q))
        for name, mesh in self._links.items():
            X = X_WL[self._robot.tree.index(name)]
            mesh.wxyz, mesh.position = wxyz_position(X)
            mesh.color = COLOURS[reach.verdict]
            mesh.visible = True

    def hide(self) -> None:
        """Hides the ghost and the target."""
        self._target.visible = False
        self._hide_links()

    def _hide_links(self) -> None:
        for mesh in self._links.values():
            mesh.visible = False

    def remove(self) -> None:
        """Removes the ghost and the target from the scene."""
        self._target.remove()
        for mesh in self._links.values():
            mesh.remove()
