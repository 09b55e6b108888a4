"""`GrowingPath`: the trace of a moving point, sent piece by piece."""

from collections import deque

import numpy as np
from pydrake.geometry import Meshcat, Rgba

from remosplat_drake.visualization.shapes import tube_mesh

_PIECE = 12  # Points in a piece; only the newest piece is sent again.
_MIN_STEP = 0.005  # [m]
_MAX_PIECES = 500  # A trace of 30 m; what is older disappears.


class GrowingPath:
    """A tube behind a moving point.

    The cost of a step does not depend on how long the trace is. A recording
    shows each piece from the time on when its first step was made.

    Args:
        meshcat: The page's Meshcat server.
        path: Path in the scene tree below which the pieces go.
        color: Colour of the tube.
        radius: Radius of the tube [m].
    """

    def __init__(
        self, meshcat: Meshcat, path: str, color: Rgba, radius: float = 0.008
    ):
        self._meshcat = meshcat
        self._path = path
        self._color = color
        self._radius = radius
        self.clear()

    def clear(self):
        """Removes the whole trace."""
        self._meshcat.Delete(self._path)
        self._points: list[np.ndarray] = []
        self._pieces: deque[str] = deque()
        self._count = 0

    def append(self, p_WP: np.ndarray, time: float):
        """Lengthens the trace to a point, unless it hardly moved.

        Args:
            p_WP: The point in W, shape (3,) [m].
            time: Time of the step in a recording [s].
        """
        if self._points:
            step = np.linalg.norm(p_WP - self._points[-1])
            if step < _MIN_STEP:
                return
        if len(self._points) == _PIECE:
            self._points = self._points[-1:]
        self._points.append(np.array(p_WP, float))
        if len(self._points) == 2:
            self._start_piece(time)
        if len(self._points) >= 2:
            vertices, faces = tube_mesh(np.array(self._points), self._radius)
            self._meshcat.SetTriangleMesh(
                self._pieces[-1], vertices.T, faces.T, self._color
            )

    def _start_piece(self, time: float):
        piece = f"{self._path}/{self._count}"
        self._count += 1
        self._pieces.append(piece)
        start = self._meshcat.get_mutable_recording().start_time()
        self._meshcat.SetProperty(
            piece, "visible", False, time_in_recording=start
        )
        self._meshcat.SetProperty(
            piece, "visible", True, time_in_recording=time
        )
        if len(self._pieces) > _MAX_PIECES:
            self._meshcat.Delete(self._pieces.popleft())
