"""`MoverCamera`: a camera that watches for movers, and its field of view."""

import dataclasses as dc
import math

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import FieldError


@dc.dataclass(frozen=True, eq=False)
class MoverCamera:
    """The space that a camera watches for movers, and its latest image time.

    The camera's frame C has z ahead, x to the right and y down. A deep copy is
    the object itself.

    Attributes:
        name: Display name of the camera.
        X_WC: Pose of the camera in W.
        least_tangent: Least x / z and y / z in its view, shape (2,).
        greatest_tangent: Greatest x / z and y / z in its view, shape (2,).
        near: Least depth z at which it can find a mover [m].
        far: Greatest depth z at which it can find a mover [m].
        seen: Time of the camera's latest usable image [s]. It determines the
            age of the information about space that no other camera watches.
        problem: Reason why there is no newer usable image; empty if there is no
            problem.

    Raises:
        FieldError: A value is not finite, or there is no space between the
            bounds.
    """

    name: str
    X_WC: RigidTransform
    least_tangent: np.ndarray
    greatest_tangent: np.ndarray
    near: float
    far: float
    seen: float
    problem: str = ""

    def __post_init__(self):
        for field in ("least_tangent", "greatest_tangent"):
            value = np.array(getattr(self, field), float)
            if value.shape != (2,) or not np.isfinite(value).all():
                self._refuse(field, "two finite numbers")
            value.flags.writeable = False
            object.__setattr__(self, field, value)
        if not (self.least_tangent < self.greatest_tangent).all():
            self._refuse("least_tangent", "below `greatest_tangent`")
        if not 0.0 <= self.near < self.far < math.inf:
            self._refuse("near", "at least 0 and below `far`")
        if not math.isfinite(self.seen):
            self._refuse("seen", "finite")
        if not np.isfinite(self.X_WC.GetAsMatrix4()).all():
            self._refuse("X_WC", "finite")

    def _refuse(self, field: str, wanted: str):
        got = getattr(self, field)
        where = f"camera {self.name!r}"
        raise FieldError(where, field, f"must be {wanted}, got {got}")

    def __deepcopy__(self, memo) -> "MoverCamera":
        return self

    def frames(self, p_W: np.ndarray) -> np.ndarray:
        """Returns which points lie in its view, ignoring occlusion.

        Args:
            p_W: Points in W, shape (n, 3) [m].

        Returns:
            Flags, shape (n,).
        """
        R_WC, p_WC = self.X_WC.rotation().matrix(), self.X_WC.translation()
        p_C = (np.asarray(p_W, float) - p_WC) @ R_WC
        depth = p_C[:, 2]
        ahead = (depth >= self.near) & (depth <= self.far)
        low = self.least_tangent * depth[:, None] <= p_C[:, :2]
        high = p_C[:, :2] <= self.greatest_tangent * depth[:, None]
        return ahead & low.all(axis=1) & high.all(axis=1)
