"""`ClearanceLines`: draws lines to the scene points that limit the robot."""

import numpy as np
from pydrake.geometry import Rgba, Sphere
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.legend import HOLDS_BACK
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.scene_look import LIVE, ROOT
from remosplat_drake.visualization.shapes import tube_mesh

KEPT = f"{LIVE}/kept_clearances"
TIGHT = f"{ROOT}/tight_clearances"

_PALE = Rgba(0.93, 0.45, 0.40)
_TUBE_RADIUS = 0.005
_DOT_RADIUS = 0.011
_SHORTEST = 1e-4  # A contact still has a direction [m].
_PALE_PERIOD = 0.2  # Shortest time between two drawings of the thin lines [s].


class ClearanceLines:
    """Draws red lines from the robot's spheres to their closest scene points.

    Each line stands for a collision constraint of the quadratic program. A
    constraint is active if it holds with equality at the command. The line of
    an active constraint is thick and opaque; all other lines are thin and pale.
    The thick lines are a fixed set of shapes that only move, so that a
    recording can contain them. A recording does not contain the thin lines.

    Args:
        page: The page to draw on.
        robot: The robot, which has the spheres.
    """

    def __init__(self, page: MeshcatPage, robot: RobotModel):
        self._scene, self._meshcat = page.scene, page.meshcat
        self._robot = robot
        self._tube = tube_mesh(np.array([[0, 0, 0], [0, 0, 1.0]]), _TUBE_RADIUS)
        self._shown: list[bool] = []
        self._pale_drawn, self._pale_time = np.zeros((2, 0, 3)), -np.inf

    def draw(self, report: TickReport, time: float):
        """Draws the clearances of one control tick.

        Args:
            report: The controller's report of the tick.
            time: Time of the tick in a recording [s].
        """
        start, end = line_ends(self._robot, report)
        pale = report.kept & ~report.tight
        self._draw_pale(np.stack((start[pale], end[pale])).round(3), time)
        tight = np.flatnonzero(report.tight)
        for i in range(len(self._shown), len(tight)):
            self._add_to_pool(i)
        for i, shown in enumerate(self._shown):
            if i < len(tight):
                self._place(i, start[tight[i]], end[tight[i]], time)
            if shown != (i < len(tight)):
                self._show(i, i < len(tight), time)

    def _draw_pale(self, ends: np.ndarray, time: float):
        """Draws the thin lines, if they have changed.

        Unchanged lines are not sent again, since Meshcat sends every shape to
        every browser, even to a slow one.
        """
        is_early = 0 <= time - self._pale_time < _PALE_PERIOD
        if is_early or np.array_equal(ends, self._pale_drawn):
            return
        self._pale_drawn, self._pale_time = ends, time
        start, end = ends
        self._meshcat.SetLineSegments(
            KEPT, start.T, end.T, line_width=1.5, rgba=_PALE
        )

    def _add_to_pool(self, i: int):
        vertices, faces = self._tube
        path = f"{TIGHT}/{i}"
        self._meshcat.SetTriangleMesh(
            f"{path}/line", vertices.T, faces.T, HOLDS_BACK
        )
        self._meshcat.SetObject(
            f"{path}/point", Sphere(_DOT_RADIUS), HOLDS_BACK
        )
        self._shown.append(False)
        self._show(i, False, time=self._scene.start)

    def _show(self, i: int, visible: bool, time: float):
        self._shown[i] = visible
        self._scene.show(f"{TIGHT}/{i}", visible, time)

    def _place(self, i: int, start: np.ndarray, end: np.ndarray, time: float):
        """Moves a dot to the scene point, and a tube from it to the sphere."""
        axis = start - end
        length = float(np.linalg.norm(axis))
        if length < _SHORTEST:
            axis, length = np.array([0.0, 0.0, 1.0]), _SHORTEST
        R = RotationMatrix.MakeFromOneVector(axis, axis_index=2)
        path = f"{TIGHT}/{i}"
        self._scene.move(path, RigidTransform(R, end), time)
        scale = [1.0, 1.0, length]
        self._scene.set_property(f"{path}/line", "scale", scale, time)


def line_ends(
    robot: RobotModel, report: TickReport
) -> tuple[np.ndarray, np.ndarray]:
    """Computes both ends of the lines for a report's m clearances.

    Args:
        robot: The robot, which has the spheres.
        report: The controller's report of a tick.

    Returns:
        Points on the spheres' surfaces and on the scene in W, shape (m, 3)
        each [m].
    """
    clearances = report.clearances
    if len(clearances) == 0:
        return np.zeros((0, 3)), np.zeros((0, 3))
    spheres = robot.holding(report.payload).spheres_at(report.q)
    i = clearances.sphere
    offset = spheres.radius[i, None] * clearances.direction_W
    return spheres.p_WS[i] + offset, clearances.p_WC
