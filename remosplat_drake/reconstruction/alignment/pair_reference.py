"""What `pair_kernel` computes, slowly and readably."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.reconstruction.alignment.pair_kernel import FLOOR, NEAR
from remosplat_drake.reconstruction.alignment.view_stack import ViewStack


class Comparison(NamedTuple):
    """A point of view a on the plane that view b has there.

    Attributes:
        point: The point in a's camera, as measured, shape (3,) [m].
        normal: Normal of b's plane in b's camera, shape (3,).
        d: Distance of the plane along it [m].
    """

    point: np.ndarray
    normal: np.ndarray
    d: float


def compare(
    stack: ViewStack,
    X_WA: np.ndarray,
    X_WB: np.ndarray,
    scale: float,
    offset: float,
    views: tuple[int, int],
    i: int,
    gate: float,
    least_cosine: float,
) -> Comparison | None:
    """Finds the plane of view b that point i of view a should lie on."""
    a, b = views
    point = stack.point[a, i]
    p_W = X_WA[:3, :3] @ _corrected(point, scale, offset) + X_WA[:3, 3]
    p_B = X_WB[:3, :3].T @ (p_W - X_WB[:3, 3])
    if p_B[2] <= NEAR:
        return None
    ray = p_B / p_B[2]
    focal, center = stack.camera[b, :2], stack.camera[b, 2:]
    column, row = np.floor(
        (focal * ray[:2] + center - 0.5) / stack.step + 0.5
    ).astype(int)
    _, rows, columns, _ = stack.plane.shape
    if not (0 <= column < columns and 0 <= row < rows):
        return None
    plane = stack.plane[b, row, column].astype(float)
    normal, d = plane[:3], plane[3]
    if d == 0 or normal @ ray > -1e-2:
        return None
    found = Comparison(point, normal, d)
    e = scale * residual(found, X_WA, X_WB, scale, offset)
    apart = abs(p_B[2] - d / (normal @ ray))
    n_W = X_WB[:3, :3] @ normal
    alike = n_W @ X_WA[:3, :3] @ stack.normal[a, i]
    if abs(e) > gate or apart > 3 * gate + 0.02 or alike < least_cosine:
        return None
    return found


def residual(
    found: Comparison,
    X_WA: np.ndarray,
    X_WB: np.ndarray,
    scale: float,
    offset: float,
) -> float:
    """Returns a point's height over a plane, in units of the sensor [m]."""
    p_W = X_WA[:3, :3] @ _corrected(found.point, scale, offset) + X_WA[:3, 3]
    p_B = X_WB[:3, :3].T @ (p_W - X_WB[:3, 3])
    ray = p_B / p_B[2]
    on_plane = _corrected(found.d / (found.normal @ ray) * ray, scale, offset)
    return float(found.normal @ (p_B - on_plane)) / scale


def deviation(
    stack: ViewStack,
    found: Comparison,
    X_WA: np.ndarray,
    X_WB: np.ndarray,
    scale: float,
    offset: float,
    views: tuple[int, int],
) -> float:
    """Returns the standard deviation of a residual, by both views' noise."""
    a, b = views
    p_W = X_WA[:3, :3] @ _corrected(found.point, scale, offset) + X_WA[:3, 3]
    p_B = X_WB[:3, :3].T @ (p_W - X_WB[:3, 3])
    n_A = X_WA[:3, :3].T @ X_WB[:3, :3] @ found.normal
    own = (n_A @ found.point) * found.point[2] * stack.deviation[a]
    z = found.d / (found.normal @ (p_B / p_B[2]))
    other = found.d * z * stack.deviation[b]
    return float(np.sqrt(own**2 + other**2 + FLOOR**2))


def _corrected(p_C: np.ndarray, scale: float, offset: float) -> np.ndarray:
    return p_C * (scale + offset / p_C[2])
