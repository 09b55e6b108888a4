"""Undistortion: converts images with lens distortion to pinhole images.

The model is the Brown-Conrady polynomial of OpenCV and nerfstudio: a ray
through (x, y) on the plane z = 1 reaches the sensor at (x_d, y_d),

    s = x^2 + y^2,  radial = 1 + k1 s + k2 s^2 + k3 s^3 + k4 s^4,
    x_d = x radial + 2 p1 x y + p2 (s + 2 x^2),
    y_d = y radial + p1 (s + 2 y^2) + 2 p2 x y.

Undistortion needs no inverse: for each pixel of the undistorted image, its
position in the distorted image is computed.
"""

import dataclasses as dc

import numpy as np
import scipy


@dc.dataclass(frozen=True)
class Distortion:
    """Brown-Conrady coefficients: radial k1 to k4, tangential p1 and p2."""

    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    k4: float = 0.0
    p1: float = 0.0
    p2: float = 0.0


def distort(distortion: Distortion, xy: np.ndarray) -> np.ndarray:
    """Applies the distortion to points (x, y) of the plane z = 1, (..., 2)."""
    d = distortion
    x, y = xy[..., 0], xy[..., 1]
    s = x**2 + y**2
    radial = 1 + s * (d.k1 + s * (d.k2 + s * (d.k3 + s * d.k4)))
    x_d = x * radial + 2 * d.p1 * x * y + d.p2 * (s + 2 * x**2)
    y_d = y * radial + d.p1 * (s + 2 * y**2) + 2 * d.p2 * x * y
    return np.stack([x_d, y_d], axis=-1)


def valid_radius(distortion: Distortion) -> float:
    """Returns the radius up to which the radial distortion is increasing.

    The radius is measured on the plane z = 1. Beyond it, the model is invalid,
    because two rays would have the same pixel. The radius is inf if the
    distortion is increasing everywhere.
    """
    d = distortion
    slope = [9 * d.k4, 7 * d.k3, 5 * d.k2, 3 * d.k1, 1.0]
    roots = np.roots(slope)
    squares = roots[(np.abs(roots.imag) < 1e-9) & (roots.real > 0)].real
    return float(np.sqrt(squares.min(initial=np.inf)))


def undistort(
    distortion: Distortion,
    K: np.ndarray,
    rgb: np.ndarray,
    depth: np.ndarray,
    hidden: np.ndarray | None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Computes the images that a pinhole camera with the same K would take.

    Colours are interpolated. Depths and masks are taken from the nearest pixel,
    since an interpolated depth between two surfaces belongs to neither.

    Args:
        distortion: Distortion of the images.
        K: Intrinsic matrix, shape (3, 3) [pixels].
        rgb: Colours, shape (h, w, 3), uint8.
        depth: Depths z, shape (h, w) [m]; their values are not changed.
        hidden: Pixels that do not show the scene, shape (h, w), or None.

    Returns:
        New colours, depths and hidden pixels. Pixels outside the distorted
        images are hidden.
    """
    height, width = depth.shape
    u, v = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    focal, center = K[[0, 1], [0, 1]], K[:2, 2]
    xy = (np.stack([u, v], axis=-1) - center) / focal
    row_column = (distort(distortion, xy) * focal + center - 0.5)[..., ::-1]
    nearest = np.rint(row_column).astype(int)
    outside = (
        (nearest < 0).any(axis=-1)
        | (nearest >= [height, width]).any(axis=-1)
        | (np.linalg.norm(xy, axis=-1) > valid_radius(distortion))
    )
    rows, columns = np.where(outside[..., None], 0, nearest).transpose(2, 0, 1)
    colors = [
        scipy.ndimage.map_coordinates(
            channel.astype(np.float32),
            row_column.transpose(2, 0, 1),
            order=1,
            mode="nearest",
        )
        for channel in np.moveaxis(rgb, -1, 0)
    ]
    new_rgb = np.rint(np.stack(colors, axis=-1)).astype(np.uint8)
    new_hidden = outside if hidden is None else outside | hidden[rows, columns]
    return (
        np.where(outside[..., None], np.uint8(0), new_rgb),
        np.where(outside, np.float32(0), depth[rows, columns]),
        new_hidden,
    )
