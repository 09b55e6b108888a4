"""Finds antipodal pairs: two surface points at which two fingers can grip.

The line through both points is inside both points' friction cones, so that two
soft fingers hold the object in every direction (Nguyen, "Constructing
force-closure grasps", IJRR 1988).
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.grasping.surface import Surface

LEAST_WIDTH = 0.003
"""Two points count as being on the same side of a wall if their distance is at
most this [m]."""

_BLOCK = 64  # Number of points whose partners are sought at once.


@dc.dataclass(frozen=True, eq=False)
class AntipodalPairs:
    """k antipodal pairs of points, in an object's frame O.

    Attributes:
        center: Middle of each pair, shape (k, 3) [m].
        axis: Unit vector from the first point to the second, along the mean of
            their normals, shape (k, 3).
        width: Distance of the two points along `axis`, shape (k,) [m].
        alignment: Cosine of the greater angle between the line through the
            points and a normal, shape (k,).
    """

    center: np.ndarray
    axis: np.ndarray
    width: np.ndarray
    alignment: np.ndarray

    def __len__(self) -> int:
        return len(self.width)


def antipodal_pairs(
    surface: Surface,
    widest: float,
    friction: float,
    most: int,
    rng: np.random.Generator,
) -> AntipodalPairs:
    """Finds antipodal pairs of points on a surface.

    The function searches partners of a point through the object, along the
    point's normal. The partners are the nearest and the farthest point for
    which the connecting line lies in both friction cones. For a cup, the
    nearest partner is on the other side of the wall, and the farthest partner
    is on the opposite wall.

    Args:
        surface: The surface.
        widest: Greatest distance of two points [m].
        friction: Coefficient of friction of fingers and object.
        most: Largest number of points whose partners are searched.
        rng: Source of randomness for the choice of these points.
    """
    first = np.arange(len(surface))
    if len(first) > most:
        first = np.sort(rng.choice(len(first), most, replace=False))
    pairs = [
        _partners(surface, first[i : i + _BLOCK], widest, friction)
        for i in range(0, len(first), _BLOCK)
    ]
    found = np.unique(np.concatenate(pairs), axis=0)
    return _described(surface, found)


def _partners(
    surface: Surface, first: np.ndarray, widest: float, friction: float
) -> np.ndarray:
    """Returns pairs of indices, shape (k, 2): a point and its partner."""
    p, n = surface.points, surface.normals
    across = p[None] - p[first, None]  # (f, n, 3)
    depth = -np.einsum("fni,fi->fn", across, n[first])
    square = np.einsum("fni,fni->fn", across, across)
    aside = np.sqrt(np.maximum(square - depth**2, 0.0))
    length = np.sqrt(np.maximum(square, 1e-18))
    leaves = np.einsum("fni,ni->fn", across, n) / length
    cone = 1.0 / np.hypot(1.0, friction)
    fits = (
        (depth > LEAST_WIDTH)
        & (length <= widest)
        & (aside <= surface.spacing)
        & (depth >= cone * length)
        & (leaves >= cone)
    )
    has = fits.any(axis=1)
    # Of several points on the same wall, the point nearest to the line is used.
    near = np.where(fits, depth + aside, np.inf).argmin(axis=1)
    far = np.where(fits, depth - aside, -np.inf).argmax(axis=1)
    both = np.concatenate([[first, near], [first, far]], axis=1)
    return both.T[np.tile(has, 2)]


def _described(surface: Surface, pairs: np.ndarray) -> AntipodalPairs:
    p, n = surface.points[pairs], surface.normals[pairs]
    across = p[:, 1] - p[:, 0]
    axis = n[:, 1] - n[:, 0]
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    line = across / np.linalg.norm(across, axis=1, keepdims=True)
    cosines = np.einsum("kci,ki->kc", n, line) * [-1.0, 1.0]
    width = np.einsum("ki,ki->k", across, axis)
    return AntipodalPairs(p.mean(axis=1), axis, width, cosines.min(axis=1))
