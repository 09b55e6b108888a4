"""Encloses points in a few small rounded boxes."""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.detection.kernels.fit_box import fit_box, rounded_volume

MOST_PARTS = 6
"""At most this many boxes enclose the points of one object."""

_GAIN = 0.75
"""Two boxes replace a single box if their total volume is at most this fraction
of its volume.
"""

_FEW = 8
"""At least this many segments are divided between two boxes."""

_SHORT = 0.35
"""A box is not divided if each of its faces is closer to its centre than this
[m]."""

_LOOKS = 100
"""A division is chosen by the volumes of boxes around at most this many
segments."""

_CUTS = ((2, 0.5), (1, 0.5), (2, 0.25), (2, 0.75))
"""Candidate divisions of the segments: index of the main axis along which they
are divided, and the fraction of segments on the lower side.
"""


@dc.dataclass(frozen=True, eq=False)
class RoundedBox:
    """All points within a radius of a box (the core): the shape of a `Mover`.

    Attributes:
        R_WM: Orientation, shape (3, 3).
        p_WM: Centre in W, shape (3,) [m].
        half_extents: Half side lengths of the core, shape (3,) [m].
        radius: Radius around the core [m].
    """

    R_WM: np.ndarray
    p_WM: np.ndarray
    half_extents: np.ndarray
    radius: float

    @property
    def X_WM(self) -> RigidTransform:
        """Pose of the box in W."""
        return RigidTransform(RotationMatrix(self.R_WM), self.p_WM)

    @property
    def volume(self) -> float:
        """Volume of the rounded box [m^3]."""
        a, b, c = self.half_extents
        return rounded_volume(a, b, c, self.radius)

    def distance(self, p_W: np.ndarray) -> np.ndarray:
        """Returns distances of points (n, 3) [m]; negative inside."""
        p_M = (p_W - self.p_WM) @ self.R_WM
        apart = np.abs(p_M) - self.half_extents
        outside = np.linalg.norm(np.maximum(apart, 0), axis=1)
        return outside + np.minimum(apart.max(axis=1), 0) - self.radius


def enclose(
    face_W: np.ndarray,
    back_W: np.ndarray,
    padding: float,
    most: int = MOST_PARTS,
) -> tuple[RoundedBox, ...]:
    """Encloses segments in one rounded box, or in several smaller ones.

    Args:
        face_W: Starts of n > 0 segments in W, shape (n, 3) [m].
        back_W: Ends of the segments, of the same shape. Each segment is inside
            one of the boxes, at least `padding` from its surface.
        padding: Margin on all sides [m].
        most: At most this many boxes are made.
    """
    pairs = np.stack([face_W, back_W], axis=1)
    parts = [(_one(pairs, padding), pairs)]
    while len(parts) < most:
        # The largest box is divided first, since this reduces the volume most.
        parts.sort(key=lambda part: -part[0].volume)
        for i, (box, members) in enumerate(parts):
            if box.half_extents.max() + box.radius < _SHORT:
                continue
            low = _division(members, padding)
            if low is not None:
                halves = members[low], members[~low]
                parts[i : i + 1] = [(_one(h, padding), h) for h in halves]
                break
        else:
            break
    return tuple(box for box, _ in parts)


def _division(pairs: np.ndarray, padding: float) -> np.ndarray | None:
    """Returns a mask of the segments that get their own box, (n,), bool.

    Returns None if two boxes are not better than one.
    """
    if len(pairs) < _FEW:
        return None
    middle = pairs.mean(axis=1)
    centered = middle - middle.mean(axis=0)
    _, axes = np.linalg.eigh(centered.T @ centered)
    every = len(pairs) // _LOOKS + 1
    few = pairs[::every]
    least = _GAIN * _one(few, padding).volume
    best = None
    for axis, share in _CUTS:
        along = centered @ axes[:, axis]
        place = np.partition(along, int(share * len(along)))
        low = along < place[int(share * len(along))]
        part = low[::every]
        if part.all() or not part.any():
            continue
        volume = sum(_one(few[s], padding).volume for s in (part, ~part))
        if volume < least:
            best, least = low, volume
    return best


def _one(pairs: np.ndarray, padding: float) -> RoundedBox:
    """Returns the smaller of a box and a capsule, along the main axes."""
    R_WM, p_WM, half_extents, radius = fit_box(pairs.reshape(-1, 3), padding)
    return RoundedBox(R_WM, p_WM, half_extents, radius)
