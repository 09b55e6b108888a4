"""`SphereView`: draws the robot's spheres, coloured by clearance."""

import numpy as np
from pydrake.geometry import Rgba, Sphere
from pydrake.math import RigidTransform

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.scene_look import ROOT
from remosplat_drake.visualization.toggle import on_off

SPHERES = f"{ROOT}/spheres"

_ALPHA = 0.45
_FAR = 0.3  # Clearance from which on a sphere is blue [m].
_COLORS = np.array([[0.85, 0.10, 0.10], [0.95, 0.70, 0.15], [0.35, 0.60, 0.90]])
_STEPS = 16


class SphereView:
    """Draws the robot's spheres translucently, red where the scene is near.

    The spheres are hidden until a viewer clicks their button. Hidden spheres
    move with the robot, too, since another viewer may show them.

    Args:
        page: The page to draw on.
        robot: The robot with the spheres.
    """

    def __init__(self, page: MeshcatPage, robot: RobotModel):
        self._scene, meshcat = page.scene, page.meshcat
        self._robot = robot
        model = robot.spheres
        self._links = tuple(dict.fromkeys(model.links))
        self._body = [robot.tree.index(link) for link in self._links]
        self._paths = [
            f"{SPHERES}/{link}/{i}" for i, link in enumerate(model.links)
        ]
        self._shade = np.full(len(model), _STEPS - 1)
        palette = clearance_colors(np.linspace(0.0, _FAR, _STEPS))
        self._palette = [[*map(float, rgb), _ALPHA] for rgb in palette]
        for i, path in enumerate(self._paths):
            meshcat.SetObject(
                path, Sphere(model.radius[i]), Rgba(*self._palette[-1])
            )
            meshcat.SetTransform(path, RigidTransform(model.p_LS[i]))
        page.add_toggle(on_off("Robot spheres", "2", SPHERES, shown=False))

    def update(self, q: np.ndarray, report: TickReport, time: float):
        """Moves and colours the spheres, except those of a carried object.

        Args:
            q: Measured configuration, shape (n_q,).
            report: The controller's report of the last tick. A sphere that has
                no clearance in the report is far from the scene.
            time: Time of the step in a recording [s].
        """
        X_WL = self._robot.body_poses(q)
        for link, body in zip(self._links, self._body, strict=True):
            X = RigidTransform(X_WL[body])
            self._scene.move(f"{SPHERES}/{link}", X, time)
        held = self._robot.holding(report.payload)
        distance = report.clearances.per_sphere(len(held.spheres))
        distance = distance[: len(self._paths)]
        fraction = np.clip(distance / _FAR, 0.0, 1.0)
        shade = np.rint((_STEPS - 1) * fraction).astype(int)
        for i in np.flatnonzero(shade != self._shade):
            node = f"{self._paths[i]}/<object>"
            self._scene.set_property(node, "color", self._palette[shade[i]])
        self._shade = shade


def clearance_colors(distance: np.ndarray) -> np.ndarray:
    """Returns colours of clearances: red at contact, then amber, blue when far.

    Args:
        distance: Clearances, shape (n,) [m].

    Returns:
        Red, green and blue from 0 to 1, shape (n, 3).
    """
    stops = np.linspace(0.0, _FAR, len(_COLORS))
    return np.stack(
        [np.interp(distance, stops, channel) for channel in _COLORS.T], axis=1
    )
