"""Depth images as maps of small planes, for lookup and sampling.

The inverse depth of a plane is linear in the image: with p = z (x, y, 1), the
plane n . p = d has 1/z = (n_x x + n_y y + n_z) / d. So 1/z = a x + b y + c is
fitted to a window of pixels by least squares. The noise of triangulating
sensors has the same size in 1/z at all depths, so the residual of the fit
measures the noise.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import numpy_kernel

RADII = (2, 4, 6)
"""Half widths of a window [pixels]. The first of them that determines the
normals well enough is used.
"""

MAX_TILT = np.deg2rad(2.0)
"""A window is large enough if the standard deviation of the normals' direction
is at most this [rad]."""

_CELLS = 160
"""Approximate number of planes along the image's longer side."""

_LEAST_SHARE = 0.7
"""Least fraction of a window's pixels that must have a depth."""

_BEND, _ROUGHNESS = 1.3, 5e-4
"""Factor and relative tolerance of flat windows: the residual of a flat window
is below 1.3 times the image's usual residual plus 5e-4 of the inverse depth.
Other windows may contain creases, which would bias poses by millimetres.
"""

_LEAST_COSINE = 0.17
"""Least cosine of incidence (80 degrees) of usable measurements."""


class PlaneMap(NamedTuple):
    """Planes n . p = d, fitted to a depth image on a lattice of its pixels.

    Attributes:
        plane: Normals towards the camera C, and distances d < 0 from its
            centre [m], shape (rows, columns, 4), float32; all 0 where the
            image shows no plane.
        camera: f_x, f_y, c_x, c_y [pixels].
        step: Distance of the lattice's points [pixels].
        deviation: Standard deviation of the planes' inverse depths at their
            centres, from the image's noise [1/m].
        tilt: Standard deviation of the normals' direction, from the image's
            noise [rad].
        independent: Number of disjoint windows, which limits the number of
            independent measurements.
    """

    plane: np.ndarray
    camera: np.ndarray
    step: int
    deviation: float
    tilt: float
    independent: float


def plane_map(
    K: np.ndarray, depth: np.ndarray, radii: tuple[int, ...] = RADII
) -> PlaneMap:
    """Fits planes to a depth image.

    Args:
        K: Intrinsic matrix, shape (3, 3) [pixels].
        depth: Depth z in C, shape (h, w) [m]; 0 where unknown.
        radii: Possible half widths of the windows, in increasing order
            [pixels].
    """
    camera = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2]], float)
    step = max(1, round(max(depth.shape) / _CELLS))
    inverse = np.zeros(depth.shape, np.float32)
    np.divide(1, depth, out=inverse, where=depth > 0)
    rows, columns = -(-depth.shape[0] // step), -(-depth.shape[1] // step)
    plane = np.zeros((rows, columns, 4), np.float32)
    rms = np.zeros((rows, columns), np.float32)
    noise = tilt = 0.0
    radius = radii[0]
    for radius in radii:
        fit_planes(camera, inverse, step, radius, _LEAST_SHARE, plane, rms)
        flat = plane[..., 3] < 0
        noise = float(np.median(rms[flat])) if flat.any() else 0.0
        nearest = np.median(-plane[flat, 3]) if flat.any() else 1.0
        slope = noise * np.sqrt(3 / (radius * (radius + 1))) / (2 * radius + 1)
        tilt = float(slope * camera[0] * nearest)
        if tilt <= MAX_TILT:
            break
    u = (np.arange(columns) * step + 0.5 - camera[2]) / camera[0]
    v = (np.arange(rows) * step + 0.5 - camera[3]) / camera[1]
    ray = np.stack(np.broadcast_arrays(u, v[:, None], 1.0), axis=-1)
    facing = -(plane[..., :3] * ray).sum(axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = facing / np.linalg.norm(ray, axis=-1)
        inverse_depth = facing / -plane[..., 3]
    limit = _BEND * noise + _ROUGHNESS * inverse_depth
    plane[~((cosine > _LEAST_COSINE) & (rms < limit))] = 0
    width = 2 * radius + 1
    independent = np.count_nonzero(plane[..., 3]) * (step / width) ** 2
    return PlaneMap(plane, camera, step, noise / width, tilt, independent)


@numpy_kernel
def fit_planes(camera, inverse, step, radius, least_share, plane, rms):
    """Fits 1/z = a x + b y + c to the window around every lattice point.

    Args:
        camera: f_x, f_y, c_x, c_y [pixels].
        inverse: Inverse depth, (h, w) [1/m]; 0 where unknown.
        step: Distance of the lattice's points [pixels].
        radius: Half width of the windows [pixels].
        least_share: Fraction of a window's depths that must be known.
        plane: Receives normal and distance, (rows, columns, 4); 0 where no
            plane was fitted.
        rms: Receives root mean square residuals of 1/z, (rows, columns) [1/m].
    """
    height, width = inverse.shape
    fx, fy, cx, cy = camera
    rows, columns = rms.shape
    least = least_share * (2 * radius + 1) ** 2
    for i in range(rows):
        for j in range(columns):
            row, column = i * step, j * step
            plane[i, j, :] = 0
            rms[i, j] = 0
            if inverse[row, column] <= 0:
                continue
            n = 0.0
            su = sv = suu = suv = svv = 0.0
            sw = suw = svw = sww = 0.0
            middle = inverse[row, column]
            for r in range(max(0, row - radius), min(height, row + radius + 1)):
                v = float(r - row)
                for c in range(
                    max(0, column - radius), min(width, column + radius + 1)
                ):
                    if inverse[r, c] <= 0:
                        continue
                    u = float(c - column)
                    w = float(inverse[r, c]) - middle
                    n += 1
                    su += u
                    sv += v
                    suu += u * u
                    suv += u * v
                    svv += v * v
                    sw += w
                    suw += u * w
                    svw += v * w
                    sww += w * w
            if n < least:
                continue
            mu, mv, mw = su / n, sv / n, sw / n
            suu -= n * mu * mu
            suv -= n * mu * mv
            svv -= n * mv * mv
            suw -= n * mu * mw
            svw -= n * mv * mw
            sww -= n * mw * mw
            det = suu * svv - suv * suv
            if det <= 0:
                continue
            a = (svv * suw - suv * svw) / det
            b = (suu * svw - suv * suw) / det
            left = sww - a * suw - b * svw
            rms[i, j] = np.sqrt(max(left, 0.0) / max(n - 3, 1.0))
            center = middle + mw - a * mu - b * mv
            # 1/z = a (u - column) + b (v - row) + center, in rays (x, y, 1).
            nx, ny = a * fx, b * fy
            nz = center + a * (cx - 0.5 - column) + b * (cy - 0.5 - row)
            length = np.sqrt(nx * nx + ny * ny + nz * nz)
            if center <= 0 or length == 0:
                continue
            plane[i, j, 0] = -nx / length
            plane[i, j, 1] = -ny / length
            plane[i, j, 2] = -nz / length
            plane[i, j, 3] = -1 / length
