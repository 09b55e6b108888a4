"""`PoseSliders`: six sliders on the page that set a pose."""

from collections.abc import Sequence

import numpy as np
from pydrake.geometry import Meshcat

from remosplat_drake.teleop.pose_coordinates import PoseCoordinates
from remosplat_drake.visualization.page_style import slider

POSITION_STEP = 0.005
"""Distance by which a press of a key moves the target [m]. A key that is held
down moves it at 0.15 m/s."""

ANGLE_STEP = 1.0
"""Angle by which a press of a key turns the target [deg]."""

_AXES = (
    ("x [m]", "KeyS", "KeyW"),
    ("y [m]", "KeyD", "KeyA"),
    ("z [m]", "KeyF", "KeyR"),
)
_ANGLES = (
    ("roll [°]", "KeyJ", "KeyL", 180.0),
    ("pitch [°]", "KeyI", "KeyK", 90.0),
    ("yaw [°]", "KeyE", "KeyQ", 180.0),
)


class PoseSliders:
    """Six sliders that set a pose: position in W, and relative rotation.

    The values are the `PoseCoordinates` of the pose.

    Args:
        meshcat: The page's Meshcat server.
        X_WH: Initial pose of the sliders, shape (4, 4).
        lower: Lower ends of the position's sliders, shape (3,) [m].
        upper: Upper ends of the position's sliders, shape (3,) [m].
    """

    def __init__(
        self,
        meshcat: Meshcat,
        X_WH: np.ndarray,
        lower: Sequence[float],
        upper: Sequence[float],
    ):
        self._meshcat = meshcat
        self._coordinates = PoseCoordinates(X_WH)
        self._names: list[str] = []
        begin = self._coordinates.of(X_WH)
        ends = zip(_AXES, lower, upper, strict=True)
        rows = [(*axis, a, b, POSITION_STEP) for axis, a, b in ends]
        rows += [
            (*angle[:3], -angle[3], angle[3], ANGLE_STEP) for angle in _ANGLES
        ]
        for (text, less, more, a, b, step), value in zip(
            rows, begin, strict=True
        ):
            keys = f"{less[-1]} {more[-1]}"
            name = slider(text, keys)
            value = float(np.clip(value, a, b))
            meshcat.AddSlider(name, a, b, step, value, less, more)
            self._names.append(name)
        self._known = self._values()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the sliders for x, y, z, roll, pitch and yaw."""
        return tuple(self._names)

    def moved(self) -> np.ndarray | None:
        """Returns the pose that a person has set since the last call.

        Returns:
            The pose X_WT, shape (4, 4); None if no slider was moved.
        """
        values = self._values()
        if values == self._known:
            return None
        self._known = values
        return self._coordinates.pose(np.array(values))

    def show(self, X_WT: np.ndarray):
        """Moves the sliders to a pose X_WT, which `moved` does not report."""
        values = self._coordinates.of(X_WT)
        for i, name in enumerate(self._names):
            step = POSITION_STEP if i < 3 else ANGLE_STEP
            # Meshcat rounds values to steps, so a change below a step is not
            # sent.
            if abs(values[i] - self._known[i]) > 0.51 * step:
                self._known[i] = self._meshcat.SetSliderValue(name, values[i])

    def _values(self) -> list[float]:
        return [self._meshcat.GetSliderValue(name) for name in self._names]
