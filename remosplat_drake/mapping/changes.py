"""Finds changes of the scene between the frames of a map.

If two frames contradict each other, the newer one is assumed to be right. A
pixel of an older frame is outdated in two cases. First, a newer frame measures
a surface behind the pixel's point, so the object at this point has vanished.
Second, a newer frame measures a surface on the pixel's ray in front of the
point, so there is a new object. Depth noise and silhouettes cause both cases in
single pixels, so only regions of some width count.
"""

import dataclasses as dc
from functools import cached_property

import numpy as np
from scipy.ndimage import (
    binary_closing,
    binary_dilation,
    binary_erosion,
    binary_propagation,
)

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.overlap import to_camera
from remosplat_drake.reconstruction.measured_space import (
    is_behind,
    nearest_around,
)

_WIDE = 0.012
"""A region counts if its largest width is at least twice this fraction of the
image's width. At a depth of 1 m and a field of view of 55 degrees, this is 2.5
cm.
"""

_BORDER = 2
"""In a border of this width around a region, pixels may show both the object
and its background [pixels]."""

_STRIDE = 2
"""Step between the rows, and between the columns, of the pixels that are
compared. It is smaller than the width of a region that counts.
"""


@dc.dataclass(frozen=True, eq=False)
class Changes:
    """Pixels of n views that contradict each other, (n, h, w) bool each.

    Attributes:
        gone: Pixels that show vanished objects.
        hidden_now: Pixels whose points are behind new objects.
        come: Pixels that show new objects.
    """

    gone: np.ndarray
    hidden_now: np.ndarray
    come: np.ndarray

    @cached_property
    def outdated(self) -> np.ndarray:
        """Pixels that newer views contradict, shape (n, h, w) bool."""
        return self.gone | self.hidden_now


def find_changes(
    capture: Capture,
    confirmed: np.ndarray | None = None,
    margin: float = 0.03,
) -> Changes:
    """Compares every view with all newer views.

    Args:
        capture: Views, oldest first.
        confirmed: Mask of the views that may contradict older views, shape
            (n,), bool; None takes all views.
        margin: Views agree if their depths differ by less than this [m]. Beyond
            a depth of 2 m, it grows with the square of the depth.
    """
    gone = np.zeros(capture.depth.shape, bool)
    hidden_now, come = np.zeros((2, *capture.depth.shape), bool)
    points = [capture.points_W(i) for i in range(len(capture))]
    fronts = [nearest_around(depth) for depth in capture.depth]
    if confirmed is None:
        confirmed = np.ones(len(capture), bool)
    for new in np.flatnonzero(confirmed).tolist():
        for old in range(new):
            gone[old] |= _seen_through(
                capture, new, fronts[new], points[old], margin
            )
            shown = _seen_through(
                capture, old, fronts[old], points[new], margin
            )
            if shown.any():
                come[new] |= shown
                hidden_now[old] |= _project(capture, points[new][shown], old)
    return Changes(gone, hidden_now, come)


def without(capture: Capture, pixels: np.ndarray) -> Capture:
    """Returns a capture in which more pixels are masked.

    Args:
        capture: n views.
        pixels: Mask of the pixels that are hidden in addition, shape (n, h, w),
            bool.
    """
    hidden = pixels
    if capture.hidden is not None:
        hidden = pixels | capture.hidden
    return dc.replace(capture, hidden=hidden)


def seen_at(
    capture: Capture, p_W: np.ndarray, view: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Projects points into a view; those outside its image are omitted.

    Args:
        capture: The views.
        p_W: The points in W, shape (n, 3) [m].
        view: Index of the view.

    Returns:
        Indices into `p_W` of the m points in the image, rows and columns of
        their pixels, and their depths z [m], each of shape (m,).
    """
    p_C = to_camera(capture, p_W, view)
    index = np.flatnonzero(p_C[:, 2] > 0)
    uvw = p_C[index] @ capture.K[view].T
    column, row = np.floor(uvw[:, :2] / uvw[:, 2:]).astype(int).T
    height, width = capture.size
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    index = index[inside]
    return index, row[inside], column[inside], p_C[index, 2]


def points_at(capture: Capture, pixels: np.ndarray) -> np.ndarray:
    """Returns the measured points of some pixels in W, shape (m, 3) [m].

    Args:
        capture: n views.
        pixels: Mask of the pixels, shape (n, h, w), bool; pixels without depth
            are omitted.
    """
    points = [
        capture.points_W(i)[pixels[i] & (capture.depth[i] > 0)]
        for i in range(len(capture))
    ]
    return np.concatenate(points)


def coherent(pixels: np.ndarray) -> np.ndarray:
    """Keeps the regions of a mask (h, w) that are wide enough."""
    radius = max(1, round(_WIDE * pixels.shape[1]))
    core = binary_erosion(pixels, np.ones((2 * radius + 1,) * 2))
    if not core.any():
        return core
    return binary_propagation(core, mask=pixels)


def _seen_through(
    capture: Capture,
    view: int,
    front: np.ndarray,
    p_W: np.ndarray,
    margin: float,
) -> np.ndarray:
    """Finds pixels whose points p_W are in the free space of a view."""
    coarse = p_W[::_STRIDE, ::_STRIDE]
    through = np.zeros(coarse.shape[:2], bool)
    known = np.isfinite(coarse[..., 0])
    through[known] = is_behind(capture, view, front, coarse[known], margin)
    through = coherent(through)
    if not through.any():
        return np.zeros(p_W.shape[:2], bool)
    height, width = p_W.shape[:2]
    fine = through.repeat(_STRIDE, axis=0).repeat(_STRIDE, axis=1)
    return _with_border(fine[:height, :width])


def _project(capture: Capture, p_W: np.ndarray, view: int) -> np.ndarray:
    """Mask of the pixels that show points (n, 3), without gaps."""
    pixels = np.zeros(capture.size, bool)
    _, row, column, _ = seen_at(capture, p_W[np.isfinite(p_W[:, 0])], view)
    pixels[row, column] = True
    return _with_border(binary_closing(pixels, np.ones((5, 5))))


def _with_border(pixels: np.ndarray) -> np.ndarray:
    return binary_dilation(pixels, np.ones((2 * _BORDER + 1,) * 2))
