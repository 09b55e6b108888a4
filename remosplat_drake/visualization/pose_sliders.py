"""`PoseSliders`: six sliders of the page that set a pose."""

from collections.abc import Sequence

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.math import RollPitchYaw, RotationMatrix

from remosplat_drake.visualization.page_style import slider

POSITION_STEP = 0.005
"""Distance by which a key moves the target [m]; held down, it is 0.15 m/s."""

ANGLE_STEP = 1.0
"""Angle by which a key turns the target [deg]."""

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
    """Six sliders: a position in W, and a rotation away from a reference.

    Angles are relative to the reference H, so that they are zero where the
    robot begins and far from where they wrap around:
    R_WT = R(roll, pitch, yaw) R_WH about W's axes.

    Args:
        meshcat: The page's Meshcat server.
        X_WH: Pose that the sliders begin at, shape (4, 4).
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
        self._R_WH = RotationMatrix.ProjectToRotationMatrix(X_WH[:3, :3])
        self._names: list[str] = []
        begin = _coordinates(X_WH, self._R_WH)
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
        X_WT = np.eye(4)
        X_WT[:3, 3] = values[:3]
        turn = RollPitchYaw(np.radians(values[3:])).ToRotationMatrix()
        X_WT[:3, :3] = (turn @ self._R_WH).matrix()
        return X_WT

    def show(self, X_WT: np.ndarray):
        """Moves the sliders to a pose X_WT; `moved` does not report that."""
        values = _coordinates(X_WT, self._R_WH)
        for i, name in enumerate(self._names):
            step = POSITION_STEP if i < 3 else ANGLE_STEP
            # Meshcat rounds to steps: what it would not show is not sent.
            if abs(values[i] - self._known[i]) > 0.51 * step:
                self._known[i] = self._meshcat.SetSliderValue(name, values[i])

    def _values(self) -> list[float]:
        return [self._meshcat.GetSliderValue(name) for name in self._names]


def _coordinates(X_WT: np.ndarray, R_WH: RotationMatrix) -> np.ndarray:
    """Position [m] and roll, pitch, yaw [deg], shape (6,)."""
    R_WT = RotationMatrix.ProjectToRotationMatrix(X_WT[:3, :3])
    angles = RollPitchYaw(R_WT @ R_WH.inverse()).vector()
    return np.concatenate([X_WT[:3, 3], np.degrees(angles)])
