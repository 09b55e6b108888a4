"""Makes a splat of a large hall, to measure the growth of time and memory.

The hall is generated, since no published splat of this size has a floor on
which a robot could stand.
"""

import numpy as np

from remosplat_drake.splat.blocks import in_blocks
from remosplat_drake.splat.gaussian_splat import GaussianSplat

SIZE = np.array([60.0, 40.0, 6.0])
"""Length, width and height of the hall [m]; the floor is z = 0."""

_PITCH = 3.0
"""Distance between neighbouring boxes on the floor, from middle to middle [m].
"""

_SMALLEST, _LARGEST = np.array([0.4, 0.4, 0.5]), np.array([1.2, 1.0, 1.3])
"""Least and greatest side lengths of a box [m]."""

_COVER = 0.8
"""Standard deviation of a disc, as a fraction of the distance to its nearest
neighbour."""

_ROUGHNESS = 0.002
"""Standard deviation of the discs' distances from a surface [m]."""

_TURNS = np.array([[1, 0, 1, 0], [1, -1, 0, 0], [1, 0, 0, 0]])
"""Quaternions wxyz that turn z to the axes x, y and z."""


def hall_scene(n: int) -> GaussianSplat:
    """Makes a hall with boxes on its floor: n discs in W, without a ceiling.

    The discs are evenly distributed over all surfaces. Equal n give equal
    discs.

    Args:
        n: Number of discs.
    """
    lower, upper = _faces()
    area = _areas(lower, upper)
    sigma = _COVER * np.sqrt(area.sum() / n)
    ends = np.cumsum(area / area.sum())

    def part(rows: slice) -> dict[str, np.ndarray]:
        rng = np.random.default_rng(rows.start)
        k = rows.stop - rows.start
        face = np.searchsorted(ends, rng.random(k)).clip(max=len(ends) - 1)
        p_WK = rng.uniform(lower[face], upper[face])
        p_WK += rng.normal(scale=_ROUGHNESS, size=(k, 3))
        normal = (upper - lower)[face].argmin(axis=1)
        return GaussianSplat(
            p_GK=p_WK,
            quaternions=_TURNS[normal],
            scales=sigma * rng.uniform(0.7, 1.3, (k, 2)),
            opacities=rng.uniform(0.3, 1.0, k),
            colors=0.4 + 0.1 * normal[:, None] + rng.uniform(0, 0.1, (k, 3)),
        ).arrays()

    return GaussianSplat.restored(in_blocks(n, part))


def _faces() -> tuple[np.ndarray, np.ndarray]:
    """Returns lower and upper corners of all flat faces, (f, 3) each [m]."""
    rng = np.random.default_rng(0)
    half = 0.5 * SIZE[:2]
    x, y = (np.arange(_PITCH - h, h - 0.5 * _PITCH, _PITCH) for h in half)
    middle = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    # The middle of the hall is free, so that a robot can start there.
    middle = middle[np.linalg.norm(middle, axis=1) > 0.5 * _PITCH]
    side = rng.uniform(_SMALLEST, _LARGEST, (len(middle), 3))
    boxes = [
        (np.append(p - 0.5 * s[:2], 0.0), np.append(p + 0.5 * s[:2], s[2]))
        for p, s in zip(middle, side, strict=True)
    ]
    hall = np.append(-half, 0.0), np.append(half, SIZE[2])
    sides = [face for box in (*boxes, hall) for face in _sides(*box)]
    tops = [_side(*box, axis=2, end=1) for box in boxes]
    floor = _side(*hall, axis=2, end=0)
    lower, upper = np.array([*sides, *tops, floor]).transpose(1, 0, 2)
    return lower, upper


def _sides(lower: np.ndarray, upper: np.ndarray) -> list[np.ndarray]:
    """Returns the four upright faces of a box."""
    return [_side(lower, upper, axis, end) for axis in (0, 1) for end in (0, 1)]


def _side(
    lower: np.ndarray, upper: np.ndarray, axis: int, end: int
) -> np.ndarray:
    """Returns the lower and upper corner of a box's face, shape (2, 3)."""
    face = np.stack([lower, upper])
    face[:, axis] = face[end, axis]
    return face


def _areas(lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Returns areas of faces that are flat along an axis, shape (f,) [m^2]."""
    return np.sort(upper - lower, axis=1)[:, 1:].prod(axis=1)
