"""Rounded boxes around points: few, and not much larger than need be."""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

MOST_PARTS = 6
"""Most boxes around the points of one thing."""

_GAIN = 0.75
"""Two boxes are worth it if they have at most this share of one's volume."""

_FEW = 8
"""So few points are never divided."""

_SHORT = 0.35
"""Boxes that reach no farther from their centres are not, either [m]."""

_CUTS = ((2, 0.5), (1, 0.5), (2, 0.25), (2, 0.75))
"""Where points may be divided: along which main axis, and at what share."""


@dc.dataclass(frozen=True, eq=False)
class RoundedBox:
    """A box with a radius around it, as a `Mover` is.

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
        """Its pose in W."""
        return RigidTransform(RotationMatrix(self.R_WM), self.p_WM)

    @property
    def volume(self) -> float:
        """Its volume [m^3]."""
        a, b, c = 2 * self.half_extents
        r = self.radius
        flat = 2 * r * (a * b + b * c + c * a)
        return (
            a * b * c + flat + np.pi * r**2 * (a + b + c) + 4 / 3 * np.pi * r**3
        )

    def distance(self, p_W: np.ndarray) -> np.ndarray:
        """Returns distances of points (n, 3) from it; negative inside [m]."""
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
    """Encloses stretches by one rounded box, or by several that are smaller.

    Args:
        face_W: Where each of n > 0 stretches begins, in W, shape (n, 3) [m].
        back_W: Where it ends, likewise. Each lies in one of the boxes, deeper
            than `padding`.
        padding: What is added on all sides [m].
        most: Most boxes.
    """
    pairs = np.stack([face_W, back_W], axis=1)
    parts = [(_one(pairs, padding), pairs)]
    while len(parts) < most:
        # The largest first: there is most to gain.
        parts.sort(key=lambda part: -part[0].volume)
        for i, (box, members) in enumerate(parts):
            if box.half_extents.max() + box.radius < _SHORT:
                continue
            halves = _divided(members, padding)
            volume = sum(half.volume for half, _ in halves)
            if halves and volume < _GAIN * box.volume:
                parts[i : i + 1] = halves
                break
        else:
            break
    return tuple(box for box, _ in parts)


def _divided(
    pairs: np.ndarray, padding: float
) -> list[tuple[RoundedBox, np.ndarray]]:
    """Two boxes around the halves of stretches, divided where it pays most.

    Empty where there are too few of them.
    """
    best: list[tuple[RoundedBox, np.ndarray]] = []
    if len(pairs) < _FEW:
        return best
    middle = pairs.mean(axis=1)
    centered = middle - middle.mean(axis=0)
    _, axes = np.linalg.eigh(centered.T @ centered)
    least = np.inf
    for axis, share in _CUTS:
        along = centered @ axes[:, axis]
        low = along <= np.quantile(along, share)
        if low.all():
            continue
        halves = [(_one(pairs[s], padding), pairs[s]) for s in (low, ~low)]
        volume = sum(half.volume for half, _ in halves)
        if volume < least:
            best, least = halves, volume
    return best


def _one(pairs: np.ndarray, padding: float) -> RoundedBox:
    """The smaller of a box and a capsule, along the points' main axes."""
    p_W = pairs.reshape(-1, 3)
    centered = p_W - p_W.mean(axis=0)
    _, axes = np.linalg.eigh(centered.T @ centered)
    if np.linalg.det(axes) < 0:
        axes[:, 0] = -axes[:, 0]
    p_M = p_W @ axes
    lower, upper = p_M.min(axis=0), p_M.max(axis=0)
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    box = RoundedBox(axes, axes @ middle, half, padding)
    capsule = _capsule(p_M - middle, axes, middle, padding)
    return min(box, capsule, key=lambda shape: shape.volume)


def _capsule(p_M, axes, middle, padding) -> RoundedBox:
    """A capsule along the last axis, which is that of greatest spread."""
    aside = np.hypot(p_M[:, 0], p_M[:, 1])
    radius = aside.max(initial=0.0)
    caps = np.sqrt(np.maximum(radius**2 - aside**2, 0.0))
    length = max(0.0, float((np.abs(p_M[:, 2]) - caps).max()))
    return RoundedBox(
        axes, axes @ middle, np.array([0, 0, length]), radius + padding
    )
