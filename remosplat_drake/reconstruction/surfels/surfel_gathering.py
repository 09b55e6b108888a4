"""Sums up depth images around each surfel: its plane, colour and votes.

`surfel_gathering_reference` is the slow, readable reference.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import numpy_helper, numpy_kernel
from remosplat_drake.capture.capture import Capture

NEAR = 0.05
"""Least distance at which a camera sees a surfel [m]."""

MAX_REACH = 6
"""Largest number of samples of a window to either side of its centre."""

PLANE_SUMS = 10
"""Number of sums for each patch in the argument `planes` of `gather_planes`."""
COLOR_SUMS = 4
"""Number of sums for each patch in the argument `colors` of `gather_planes`."""

GRID = 14
"""Number of cells along a side of a surfel's grid of votes."""


class DepthView(NamedTuple):
    """One view of a `Capture`, as arrays for the kernels.

    Attributes:
        depth: Depth z in C, shape (h, w) [m]; 0 where unknown.
        rgb: Colours, shape (h, w, 3).
        focal: Focal lengths along x and y, shape (2,) [pixels].
        center: Principal point, shape (2,) [pixels].
        R_WC: Orientation of the camera, shape (3, 3).
        p_WC: Position of the camera, shape (3,) [m].
    """

    depth: np.ndarray
    rgb: np.ndarray
    focal: np.ndarray
    center: np.ndarray
    R_WC: np.ndarray
    p_WC: np.ndarray


class Patches(NamedTuple):
    """Surfels, each with a tangent frame K and a window around it.

    Attributes:
        p_WK: Centres, shape (n, 3) [m].
        R_WK: Columns are two tangents and the normal, shape (n, 3, 3).
        radius: Radii of the windows, shape (n,) [m].
        colors: RGB in [0, 1], shape (n, 3).
    """

    p_WK: np.ndarray
    R_WK: np.ndarray
    radius: np.ndarray
    colors: np.ndarray


class DepthNoise(NamedTuple):
    """Noise model of a measured depth z.

    Attributes:
        floor: Standard deviation of the depth near the camera [m].
        growth: Growth of the standard deviation with z^2 [1/m].
        min_cosine: Least cosine of the angle of incidence at which a view is
            used for a surfel.
        color_step: Difference of colour at which a sample's weight is halved.
    """

    floor: float
    growth: float
    min_cosine: float
    color_step: float

    def deviation(self, z: np.ndarray) -> np.ndarray:
        """Returns the standard deviations of depths z [m]."""
        return self.floor + self.growth * z**2


def make_view(capture: Capture, i: int) -> DepthView:
    """Makes the `DepthView` of view i of a capture."""
    K, X_WC = capture.K[i], capture.X_WC[i]
    return DepthView(
        capture.depth[i],
        capture.rgb[i],
        np.array([K[0, 0], K[1, 1]], float),
        np.array([K[0, 2], K[1, 2]], float),
        np.array(X_WC[:3, :3], float, order="C"),
        np.array(X_WC[:3, 3], float),
    )


@numpy_kernel
def gather_planes(patches, view, noise, tolerance, planes, colors):
    """Adds a view's measured points to the sums of the patches near them.

    A pixel's point with tangential coordinates a, b and height h has the weight

    w = cos^2 (1 - (a^2 + b^2) / radius^2) / ((1 + (h / c)^2)^2 sigma^2),

    where sigma is the noise of its depth, cos the cosine of the angle of
    incidence, and c the larger of `tolerance` and 3 sigma (Geman and McClure,
    1985).

    Args:
        patches: The patches.
        view: The view.
        noise: The noise of the view's depth.
        tolerance: Distance from a patch's plane up to which points belong to
            its surface, regardless of their noise [m].
        planes: Receives the sums of w times 1, a, b, a a, a b, b b, h, a h, b
            h, (h / sigma)^2, shape (n, PLANE_SUMS).
        colors: Receives sums of weighted RGB and of the weights, with and
            without robust weighting, shape (n, COLOR_SUMS).
    """
    for i in range(len(patches.p_WK)):
        window, cosine = _window(patches, i, view, noise)
        if cosine <= 0:
            continue
        top, bottom, left, right, step = window
        for row in range(top, bottom, step):
            for column in range(left, right, step):
                z = view.depth[row, column]
                if z <= 0:
                    continue
                a, b, h = _local_point(patches, i, view, row, column, z)
                sigma = noise.floor + noise.growth * z * z
                c = max(tolerance, 3 * sigma)
                inner = 1 - (a * a + b * b) / patches.radius[i] ** 2
                if inner <= 0 or abs(h) > 3 * c:
                    continue
                w = cosine**2 * inner / ((1 + (h / c) ** 2) ** 2 * sigma**2)
                _add_point(planes[i], w, a, b, h, h / sigma)
                rgb = view.rgb[row, column]
                _add_color(colors[i], w * inner, rgb, patches.colors[i], noise)


@numpy_kernel
def gather_votes(patches, view, noise, tolerance, solid, free):
    """Adds a view's votes for each patch's surface and for free space.

    The ray of a pixel meets a patch's plane in one cell of a grid over the
    window. Let c be the larger of `tolerance` and 2 sigma along the normal. If
    the measured point is within c of the plane, the cell receives a vote for a
    surface. If the point is more than 1.5 c behind the plane, the cell receives
    a vote for free space. If it is in front, the cell is occluded and receives
    no vote. Each view has one vote for each cell; the pixels in the cell share
    it.

    Args:
        patches: The patches.
        view: The view.
        noise: The noise of the view's depth.
        tolerance: Distance from a patch's plane up to which points belong to
            its surface, regardless of their noise [m].
        solid: Receives votes for a surface, by cell, shape (n, GRID, GRID).
        free: Receives votes for free space, by cell, shape (n, GRID, GRID).
    """
    votes = np.zeros((2, GRID, GRID))
    for i in range(len(patches.p_WK)):
        window, cosine = _window(patches, i, view, noise)
        if cosine <= 0:
            continue
        top, bottom, left, right, step = window
        votes[:] = 0
        cell = 2 * patches.radius[i] / GRID
        for row in range(top, bottom, step):
            for column in range(left, right, step):
                z = view.depth[row, column]
                if z <= 0:
                    continue
                ray_a, ray_b, slope = _local_ray(patches, i, view, row, column)
                a, b, h = _local_point(patches, i, view, row, column, z)
                sigma = noise.floor + noise.growth * z * z
                c = max(tolerance, 2 * sigma * abs(slope))
                if slope > -0.5 * noise.min_cosine or h > c:
                    continue
                if -1.5 * c < h < -c:
                    continue
                back = h / slope
                ka = int(np.floor((a - back * ray_a) / cell + GRID / 2))
                kb = int(np.floor((b - back * ray_b) / cell + GRID / 2))
                if 0 <= ka < GRID and 0 <= kb < GRID:
                    votes[0 if h >= -c else 1, ka, kb] += 1
        for ka in range(GRID):
            for kb in range(GRID):
                total = votes[0, ka, kb] + votes[1, ka, kb]
                if total > 0:
                    solid[i, ka, kb] += votes[0, ka, kb] / total
                    free[i, ka, kb] += votes[1, ka, kb] / total


@numpy_helper
def _add_point(sums, w, a, b, h, deviations):
    sums[0] += w
    sums[1] += w * a
    sums[2] += w * b
    sums[3] += w * a * a
    sums[4] += w * a * b
    sums[5] += w * b * b
    sums[6] += w * h
    sums[7] += w * a * h
    sums[8] += w * b * h
    sums[9] += w * deviations * deviations


@numpy_helper
def _add_color(sums, w, rgb, expected, noise):
    off = 0.0
    for k in range(3):
        off += (rgb[k] / 255.0 - expected[k]) ** 2
    w /= 1 + off / noise.color_step**2
    for k in range(3):
        sums[k] += w * rgb[k] / 255.0
    sums[3] += w


@numpy_helper
def _window(patches, i, view, noise):
    """Pixels around a patch (top, bottom, left, right, step), and its cosine.

    The cosine is that of the angle between normal and line of sight; 0 where
    the view does not see the patch.
    """
    nothing = (0, 0, 0, 0, 1)
    x, y, z, facing, squared = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        offset = patches.p_WK[i, k] - view.p_WC[k]
        x += view.R_WC[k, 0] * offset
        y += view.R_WC[k, 1] * offset
        z += view.R_WC[k, 2] * offset
        facing -= patches.R_WK[i, k, 2] * offset
        squared += offset * offset
    if z < NEAR or facing < noise.min_cosine * np.sqrt(squared):
        return nothing, 0.0
    height, width = view.depth.shape
    column = int(np.floor(view.focal[0] * x / z + view.center[0]))
    row = int(np.floor(view.focal[1] * y / z + view.center[1]))
    if not (0 <= column < width and 0 <= row < height):
        return nothing, 0.0
    reach = int(np.ceil(patches.radius[i] * view.focal[0] / z))
    step = (reach + MAX_REACH - 1) // MAX_REACH
    reach = reach // step * step
    # If the image's border cuts the window, the samples' positions do not
    # change.
    top = row - min(reach, row // step * step)
    left = column - min(reach, column // step * step)
    bottom = min(height, row + reach + 1)
    right = min(width, column + reach + 1)
    return (top, bottom, left, right, step), facing / np.sqrt(squared)


@numpy_helper
def _local_ray(patches, i, view, row, column):
    """A pixel's ray of unit depth in a patch's frame."""
    x = (column + 0.5 - view.center[0]) / view.focal[0]
    y = (row + 0.5 - view.center[1]) / view.focal[1]
    a, b, h = 0.0, 0.0, 0.0
    for k in range(3):
        ray = view.R_WC[k, 0] * x + view.R_WC[k, 1] * y + view.R_WC[k, 2]
        a += patches.R_WK[i, k, 0] * ray
        b += patches.R_WK[i, k, 1] * ray
        h += patches.R_WK[i, k, 2] * ray
    return a, b, h


@numpy_helper
def _local_point(patches, i, view, row, column, z):
    """A pixel's point in a patch's frame."""
    a, b, h = _local_ray(patches, i, view, row, column)
    a, b, h = z * a, z * b, z * h
    for k in range(3):
        offset = view.p_WC[k] - patches.p_WK[i, k]
        a += patches.R_WK[i, k, 0] * offset
        b += patches.R_WK[i, k, 1] * offset
        h += patches.R_WK[i, k, 2] * offset
    return a, b, h
