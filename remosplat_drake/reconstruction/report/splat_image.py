"""Renders colour and depth images of a splat through any pinhole camera.

The images are computed on the CPU, so neither a GPU nor a training framework is
needed to view a reconstruction. The images equal those of
`splat_image_reference.render`, pixel for pixel.
"""

import dataclasses as dc
from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import numpy_kernel
from remosplat_drake.oracle.depth_sensor import FILTER_SCALE, DepthSensor
from remosplat_drake.oracle.kernels.footprints import (
    footprint_records,
    fragment,
    fragment_alpha,
    lean,
    make_rules,
    pixel_span,
    project,
)
from remosplat_drake.oracle.kernels.outlines import (
    column_span,
    outline,
    row_span,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat

NEAR, FAR = 0.01, 100.0
"""Least and largest depth z of visible fragments [m]."""

SENSOR = DepthSensor(near=NEAR, far=FAR)
"""The oracle's definition of a fragment (3 sigma, alpha >= 1/255)."""

_BAND = 32  # Rows of pixels that are drawn together, to stay in the cache.


@dc.dataclass(frozen=True, eq=False)
class SplatImage:
    """Colour and depth of a splat through a pinhole camera C.

    Attributes:
        color: Expected colour over black, shape (h, w, 3), float32.
        depth: Median depth z in C, shape (h, w), float32 [m]; 0 where the
            splats absorb less than half of the light.
        alpha: Accumulated alpha, shape (h, w), float32.
    """

    color: np.ndarray
    depth: np.ndarray
    alpha: np.ndarray


class _Camera(NamedTuple):
    """A pinhole camera C, as the kernels need it.

    R_WN maps a point (x, y, 1) of the image square [-1, 1]^2 to the ray
    through it with unit depth z; the kernels of the depth views support no
    other camera.
    """

    p_WC: np.ndarray
    R_WN: np.ndarray
    width: int
    height: int


class SplatRenderer:
    """Renders a splat, with fragments sorted along each ray.

    Fragments are those of `DepthSensor`, with the exact intersection of ray and
    disc; colours are those of spherical-harmonics degree 0.

    Args:
        splat_W: The scene, expressed in W.
        low_pass_filter: Whether to use the screen-space filter of 2DGS (after
            Botsch et al., 2005), with which splats are usually trained. It
            makes every splat cover at least a dot of about a pixel, which has
            the depth of the splat's centre.
    """

    def __init__(self, splat_W: GaussianSplat, *, low_pass_filter: bool = True):
        self._rules = make_rules(SENSOR, splat_W.is_surfel)
        self._records, _ = footprint_records(splat_W, SENSOR)
        index = self._records[:, 15].astype(np.int64)
        self._colors = splat_W.colors[index].astype(float)
        self._low_pass_filter = low_pass_filter

    def render(
        self, K: np.ndarray, X_WC: np.ndarray, size: tuple[int, int]
    ) -> SplatImage:
        """Renders the image of a camera.

        Args:
            K: Intrinsic matrix, shape (3, 3) [pixels].
            X_WC: Camera pose (OpenCV axes), shape (4, 4).
            size: Height and width [pixels].
        """
        height, width = size
        to_pixel = np.array(
            [[width / 2, 0, width / 2], [0, height / 2, height / 2], [0, 0, 1]]
        )
        R_WC, p_WC = X_WC[:3, :3], X_WC[:3, 3]
        R_WN = R_WC @ np.linalg.inv(K) @ to_pixel
        camera = _Camera(p_WC.copy(), R_WN, width, height)
        center = self._centers(K, R_WC, p_WC)
        # From far to near, so that a new fragment is usually the first of its
        # pixel.
        order = np.argsort(-center[:, 2], kind="stable")
        order = order[center[order, 2] + self._records[order, 14] >= NEAR]
        rows = np.empty((len(order), 2), np.int64)
        _find_rows(self._records, self._rules, camera, center, order, rows)
        color = np.zeros((height, width, 3), np.float32)
        depth = np.zeros((height, width), np.float32)
        alpha = np.zeros((height, width), np.float32)
        for first in range(0, height, _BAND):
            last = min(first + _BAND, height) - 1
            met = (rows[:, 0] <= last) & (rows[:, 1] >= first)
            _draw_band(
                self._records,
                self._colors,
                self._rules,
                camera,
                center,
                order[met],
                first,
                last,
                color,
                depth,
                alpha,
            )
        return SplatImage(color, depth, alpha)

    def _centers(
        self, K: np.ndarray, R_WC: np.ndarray, p_WC: np.ndarray
    ) -> np.ndarray:
        """Rows [u, v, z, dot]: pixel, depth and size of each splat's centre.

        `dot` is the radius of the filter's footprint; negative for splats
        without one [px].
        """
        p_CK = (self._records[:, :3] - p_WC) @ R_WC
        uvw = p_CK @ K.T
        center = np.full((len(p_CK), 4), -1.0)
        center[:, 2] = p_CK[:, 2]
        ahead = p_CK[:, 2] > NEAR
        center[ahead, :2] = uvw[ahead, :2] / uvw[ahead, 2:]
        if self._low_pass_filter:
            cut = self._records[ahead, 13]
            center[ahead, 3] = np.sqrt(cut / FILTER_SCALE)
        return center


@numpy_kernel
def _find_rows(records, rules, camera, center, order, rows):
    """Writes the first and last image row that each splat may touch."""
    for i in range(len(order)):
        k = order[i]
        s = project(records, k, rules, camera.p_WC, camera.R_WN)
        edge = outline(s, rules, records[k, 13])
        low, high = row_span(s, rules, edge)
        first, last = _whole_span(low, high, camera.height)
        rows[i, 0], rows[i, 1] = _with_dot(
            first, last, center[k, 1], center[k, 3], camera.height
        )


@lean
def _whole_span(low, high, count):
    first, last = pixel_span(low, high, count)
    return int(first), int(last)


@lean
def _with_dot(first, last, middle, dot, count):
    """A span of pixels, empty if first > last, enlarged by middle +- dot."""
    if dot < 0:
        return first, last
    # Pixel i has its centre at i + 1/2.
    low = np.floor(min(max(middle - dot - 0.5, -1.0), count))
    high = np.ceil(max(min(middle + dot - 0.5, count), -1.0))
    if low > count - 1 or high < 0:
        return first, last
    low, high = max(int(low), 0), min(int(high), count - 1)
    if first > last:
        return low, high
    return min(first, low), max(last, high)


@numpy_kernel
def _draw_band(
    records,
    colors,
    rules,
    camera,
    center,
    order,
    first_row,
    last_row,
    color,
    depth,
    alpha,
):
    """Draws the rows first_row to last_row of an image.

    Each pixel has a linked list of fragments, near to far: `head` is its first
    fragment, `link` the next one, and -1 ends the list.
    """
    width = camera.width
    head = np.full((last_row + 1 - first_row, width), -1, np.int64)
    values = np.empty((1 << 16, 2))
    link = np.empty(1 << 16, np.int64)
    owner = np.empty(1 << 16, np.int64)
    count = 0
    for k in order:
        s = project(records, k, rules, camera.p_WC, camera.R_WN)
        edge = outline(s, rules, records[k, 13])
        low, high = row_span(s, rules, edge)
        first, last = _whole_span(low, high, camera.height)
        u, v, _, dot = center[k]
        first, last = _with_dot(first, last, v, dot, camera.height)
        for row in range(max(first, first_row), min(last, last_row) + 1):
            y = (row + 0.5) * 2 / camera.height - 1
            low, high = column_span(s, rules, edge, y)
            left, right = _whole_span(low, high, width)
            if abs(row + 0.5 - v) <= dot:
                left, right = _with_dot(left, right, u, dot, width)
            if count + width > len(link):
                values = np.concatenate((values, np.empty_like(values)))
                link = np.concatenate((link, np.empty_like(link)))
                owner = np.concatenate((owner, np.empty_like(owner)))
            for column in range(left, right + 1):
                z, a = _fragment_at(
                    s, rules, camera, center[k], records[k, 12], row, column
                )
                if a > 0:
                    values[count, 0], values[count, 1] = z, a
                    owner[count] = k
                    _insert(head, row - first_row, column, link, values, count)
                    count += 1
    band = slice(first_row, last_row + 1)
    _composite_all(
        head, link, owner, values, colors, color[band], depth[band], alpha[band]
    )


@lean
def _fragment_at(s, rules, camera, center, opacity, row, column):
    """Depth z and alpha of a projected splat at a pixel; 0 if unseen."""
    x = (column + 0.5) * 2 / camera.width - 1
    y = (row + 0.5) * 2 / camera.height - 1
    z, weight = fragment(s, rules, x, y)
    if center[3] >= 0:
        du, dv = column + 0.5 - center[0], row + 0.5 - center[1]
        filtered = FILTER_SCALE * (du * du + dv * dv)
        if not weight <= filtered:
            z, weight = center[2], filtered
    return z, fragment_alpha(z, weight, opacity, rules)


@lean
def _insert(head, row, column, link, values, new):
    """Puts a fragment before the first one of its pixel that is not nearer."""
    z = values[new, 0]
    at = head[row, column]
    if at < 0 or values[at, 0] >= z:
        link[new] = at
        head[row, column] = new
        return
    while link[at] >= 0 and values[link[at], 0] < z:
        at = link[at]
    link[new] = link[at]
    link[at] = new


@numpy_kernel
def _composite_all(head, link, owner, values, colors, color, depth, alpha):
    """Composites the fragments of each pixel, from its first one on."""
    for row in range(head.shape[0]):
        for column in range(head.shape[1]):
            clear, red, green, blue = 1.0, 0.0, 0.0, 0.0
            at = head[row, column]
            while at >= 0:
                if clear > 0.5:
                    depth[row, column] = values[at, 0]
                k, weight = owner[at], clear * values[at, 1]
                red += weight * colors[k, 0]
                green += weight * colors[k, 1]
                blue += weight * colors[k, 2]
                clear *= 1 - values[at, 1]
                at = link[at]
            if clear >= 0.5:
                depth[row, column] = 0.0
            alpha[row, column] = 1 - clear
            color[row, column, 0] = red
            color[row, column, 1] = green
            color[row, column, 2] = blue
