"""`GrowingPath`: draws the trace of a moving point, piece by piece."""

from collections import deque

import numpy as np
from pydrake.geometry import Rgba

from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.shapes import tube_mesh

_PIECE = 12  # Points in a piece; only the newest piece is sent again.
_MIN_STEP = 0.005  # [m]
_PERIOD = 0.2  # Longest time that a step is not drawn [s].
_MAX_PIECES = 500  # A trace of 30 m; what is older disappears.


class GrowingPath:
    """A tube along the trace of a moving point.

    The cost of a step does not depend on the length of the trace. Steps are
    sent in groups (pieces), since Meshcat sends every shape to every browser,
    even to a slow one. A recording shows each piece from the time of its first
    step on.

    Args:
        page: The page to draw on.
        path: Path in the scene tree below which the pieces are drawn.
        color: Colour of the tube.
        radius: Radius of the tube [m].
    """

    def __init__(
        self, page: MeshcatPage, path: str, color: Rgba, radius: float = 0.008
    ):
        self._scene, self._meshcat = page.scene, page.meshcat
        self._path = path
        self._color = color
        self._radius = radius
        self.clear()

    def clear(self):
        """Removes the whole trace."""
        self._scene.delete(self._path)
        self._points: list[np.ndarray] = []
        self._pieces: deque[str] = deque()
        self._count = 0
        self._is_drawn, self._drawn_at = True, -np.inf

    def append(self, p_WP: np.ndarray, time: float):
        """Extends the trace to a point, unless the point has hardly moved.

        Args:
            p_WP: The point in W, shape (3,) [m].
            time: Time of the step in a recording [s].
        """
        points = self._points
        if not points or np.linalg.norm(p_WP - points[-1]) >= _MIN_STEP:
            if len(points) == _PIECE:
                self._points = points = points[-1:]
            points.append(np.array(p_WP, float))
            if len(points) == 2:
                self._start_piece(time)
            self._is_drawn = len(points) < 2
        is_due = not 0 <= time - self._drawn_at < _PERIOD
        if not self._is_drawn and (is_due or len(points) == _PIECE):
            self._is_drawn, self._drawn_at = True, time
            vertices, faces = tube_mesh(np.array(points), self._radius)
            self._meshcat.SetTriangleMesh(
                self._pieces[-1], vertices.T, faces.T, self._color
            )

    def _start_piece(self, time: float):
        piece = f"{self._path}/{self._count}"
        self._count += 1
        self._pieces.append(piece)
        self._scene.show(piece, False, self._scene.start)
        self._scene.show(piece, True, time)
        if len(self._pieces) > _MAX_PIECES:
            self._scene.delete(self._pieces.popleft())
