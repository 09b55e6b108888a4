"""`choose_keyframes`: selects a few frames that cover a long capture.

A hand-held camera sees each surface dozens of times from almost the same
position. So space is divided into voxels, and frames are selected one by one.
The next frame is the one with the greatest gain (the greedy covering of
Nemhauser, Wolsey and Fisher, 1978). The gain of a frame is a sum over the
voxels that it shows. A voxel contributes most if few selected frames show it,
and if none shows it from the same direction. Blurred frames have a lower
weight.
"""

import dataclasses as dc
import heapq
from collections.abc import Sequence
from itertools import product

import numpy as np

from remosplat_drake.capture.capture import back_project
from remosplat_drake.capture.frames import sample_nearest, scale_intrinsics

VOXEL = 0.1
"""Edge length of the voxels into which surfaces are divided [m]."""

EXPOSURE = 1 / 60
"""Typical exposure time of a phone or an RGB-D camera indoors [s]."""

_COARSE = 64
"""Before depth images are evaluated, they are reduced to at most this width and
height [pixels]."""

_WORTH = 0.5
"""The first view of a voxel has the gain 1. Each further view has this fraction
of the gain of the view before. More views average the noise, but the first few
views matter most.
"""

_BLURRED_WORTH = 0.1
"""Weight of a completely blurred image. It is above 0, so that a blurred image
is selected if no sharp image shows its surfaces.
"""

_DIRECTION_WORTH = 0.5
"""The first view of a voxel from a new direction has this additional gain."""

_AXIS_BITS, _DIRECTION_BITS = 19, 5
"""Numbers of bits with which the three indices of a voxel and a viewing
direction are packed into one integer."""


@dc.dataclass(frozen=True, eq=False)
class Keyframes:
    """The selected frames, and the fraction of surfaces that they do not show.

    Attributes:
        chosen: Indices of the selected frames, ascending, shape (k,).
        frames: Number of all frames.
        missed: Fraction of all voxels with surfaces that no selected frame
            shows. A voxel also counts as shown if one of its 26 neighbours is
            shown, since noise moves surfaces between voxels.
    """

    chosen: np.ndarray
    frames: int
    missed: float

    @property
    def words(self) -> str:
        """One sentence that states the number of used frames."""
        return (
            f"{len(self.chosen)} of {self.frames} frames are used;"
            f" {100 * self.missed:.1f} % of the captured surfaces are only in "
            "the remaining frames"
        )


def looks_of_view(
    K: np.ndarray, depth: np.ndarray, X_WC: np.ndarray
) -> np.ndarray:
    """Finds the voxels that a depth image shows, and the viewing directions.

    Args:
        K: Intrinsic matrix, shape (3, 3) [pixels].
        depth: Depth z in C, shape (h, w) [m]; 0 where unknown.
        X_WC: Camera pose (OpenCV axes), shape (4, 4).

    Returns:
        Integers that encode voxel and viewing direction, ascending and unique.
        There are 24 directions, which differ in the largest component or in the
        signs of the three components.
    """
    height, width = depth.shape
    shrink = max(height, width, _COARSE) / _COARSE
    size = max(1, round(height / shrink)), max(1, round(width / shrink))
    K = scale_intrinsics(K, (height, width), size)
    p_W = back_project(K, sample_nearest(depth, size), X_WC).reshape(-1, 3)
    p_W = p_W[np.isfinite(p_W[:, 0])]
    most = 1 << (_AXIS_BITS - 1)
    cell = np.floor(p_W / VOXEL).clip(-most, most - 1).astype(np.int64) + most
    ray_W = p_W - X_WC[:3, 3]
    signs = (ray_W > 0) @ np.array([1, 2, 4])
    look = 8 * np.abs(ray_W).argmax(axis=1) + signs
    for axis in range(3):
        look += cell[:, axis] << (_DIRECTION_BITS + axis * _AXIS_BITS)
    return np.unique(look)


def sharpness(velocity_W: np.ndarray, focal: float, depth: float) -> float:
    """Computes the sharpness of an image from the camera's motion.

    Args:
        velocity_W: Angular velocity [rad/s] and velocity of the camera's
            centre [m/s], shape (6,); NaN if unknown.
        focal: Focal length of the image [pixels].
        depth: Typical depth in the image [m].

    Returns:
        Sharpness: 1 for a camera at rest or of unknown motion, 1/2 for a blur
        of one pixel, falling with the square of the blur.
    """
    turning, moving = np.linalg.norm(velocity_W.reshape(2, 3), axis=1)
    blur = EXPOSURE * focal * (turning + moving / depth)
    return float(1 / (1 + blur**2)) if np.isfinite(blur) else 1.0


def choose_keyframes(
    looks: Sequence[np.ndarray], sharp: np.ndarray, most: int
) -> Keyframes:
    """Selects frames that together show the surfaces of all frames.

    Args:
        looks: Result of `looks_of_view` for each of the n frames.
        sharp: Result of `sharpness` for each frame, shape (n,).
        most: Largest number of frames that are chosen.
    """
    n = len(looks)
    every = np.concatenate([*looks, np.zeros(0, np.int64)])
    kinds, look = np.unique(every, return_inverse=True)
    voxels, voxel_of_look = np.unique(
        kinds >> _DIRECTION_BITS, return_inverse=True
    )
    starts = np.cumsum([len(numbers) for numbers in looks])[:-1]
    directions = np.split(look, starts)
    places = [np.unique(voxel_of_look[look]) for look in directions]
    views = np.zeros(len(voxels), np.int64)
    is_seen = np.zeros(len(kinds), bool)
    worth = _BLURRED_WORTH + (1 - _BLURRED_WORTH) * sharp

    def gain(i: int) -> float:
        fresh = np.count_nonzero(~is_seen[directions[i]])
        more = float((_WORTH ** views[places[i]]).sum())
        return float(worth[i]) * (more + _DIRECTION_WORTH * fresh)

    # Gains never increase. So if a recomputed gain is still the largest in the
    # queue, it is the largest of all. Of equal gains, the first frame's is
    # used.
    waiting = [(-np.inf, i) for i in range(n)]
    chosen: list[int] = []
    while waiting and len(chosen) < most:
        _, i = waiting[0]
        now = gain(i)
        if now <= 0:
            heapq.heappop(waiting)
        elif len(waiting) == 1 or (-now, i) <= min(waiting[1:3]):
            heapq.heappop(waiting)
            chosen.append(i)
            views[places[i]] += 1
            is_seen[directions[i]] = True
        else:
            heapq.heapreplace(waiting, (-now, i))
    if not chosen:  # No frame has a depth: `check_reconstructible` fails.
        chosen = list(range(min(n, most)))
    return Keyframes(
        np.array(sorted(chosen), np.int64), n, _missed(voxels, views > 0)
    )


def _missed(voxels: np.ndarray, is_seen: np.ndarray) -> float:
    """Fraction of the voxels that are not seen and have no seen neighbour."""
    missed = voxels[~is_seen]
    for x, y, z in product((-1, 0, 1), repeat=3):
        step = x + (y << _AXIS_BITS) + (z << 2 * _AXIS_BITS)
        missed = missed[~np.isin(missed + step, voxels[is_seen])]
    return len(missed) / max(len(voxels), 1)
