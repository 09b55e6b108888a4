"""Slow, readable reference of `pair_kernel`."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.reconstruction.alignment.pair_kernel import FLOOR, NEAR
from remosplat_drake.reconstruction.alignment.view_stack import ViewStack


class Camera(NamedTuple):
    """Parameters of a view's camera that determine how errors displace points.

    Attributes:
        focal: f_x and f_y, shape (2,) [pixels].
        center: c_x and c_y, shape (2,) [pixels].
        height: Height of the image [pixels].
        omega_C: Angular velocity of the camera in C, shape (3,) [rad/s].
        v_C: Velocity of its centre in C, shape (3,) [m/s].
    """

    focal: np.ndarray
    center: np.ndarray
    height: float
    omega_C: np.ndarray
    v_C: np.ndarray


class Comparison(NamedTuple):
    """A measured point of one view, and another view's plane at this point.

    Attributes:
        point: The measured point in the camera axes of the first view, shape
            (3,) [m].
        normal: Normal of the plane in the camera axes of the second view, shape
            (3,).
        d: Distance of the plane from the second camera along `normal` [m].
        cameras: The cameras of the first and of the second view.
    """

    point: np.ndarray
    normal: np.ndarray
    d: float
    cameras: tuple[Camera, Camera]


def compare(
    stack: ViewStack,
    X_WA: np.ndarray,
    X_WB: np.ndarray,
    errors: np.ndarray,
    views: tuple[int, int],
    i: int,
    gate: float,
    least_cosine: float,
) -> Comparison | None:
    """Finds the plane of view b on which point i of view a should lie."""
    a, b = views
    cameras = _camera(stack, a), _camera(stack, b)
    point = stack.point[a, i]
    p_B = _in_other_view(displaced(cameras[0], errors, point), X_WA, X_WB)
    if p_B[2] <= NEAR:
        return None
    ray = p_B / p_B[2]
    pixel = cameras[1].focal * ray[:2] + cameras[1].center
    column, row = np.floor((pixel - 0.5) / stack.step + 0.5).astype(int)
    _, rows, columns, _ = stack.plane.shape
    if not (0 <= column < columns and 0 <= row < rows):
        return None
    plane = stack.plane[b, row, column].astype(float)
    normal, d = plane[:3], plane[3]
    if d == 0 or normal @ ray > -1e-2:
        return None
    found = Comparison(point, normal, d, cameras)
    e = _scale(errors) * residual(found, X_WA, X_WB, errors)
    apart = abs(p_B[2] - d / (normal @ ray))
    n_W = X_WB[:3, :3] @ normal
    alike = n_W @ X_WA[:3, :3] @ stack.normal[a, i]
    if abs(e) > gate or apart > 3 * gate + 0.02 or alike < least_cosine:
        return None
    return found


def residual(
    found: Comparison, X_WA: np.ndarray, X_WB: np.ndarray, errors: np.ndarray
) -> float:
    """Returns a point's distance from the plane, divided by the scale [m]."""
    p_B = _in_other_view(_true_point(found, errors), X_WA, X_WB)
    on_plane = displaced(found.cameras[1], errors, _plane_point(found, p_B))
    return float(found.normal @ (p_B - on_plane)) / _scale(errors)


def deviation(
    stack: ViewStack,
    found: Comparison,
    X_WA: np.ndarray,
    X_WB: np.ndarray,
    errors: np.ndarray,
    views: tuple[int, int],
) -> float:
    """Returns the standard deviation of a residual due to both views' noise."""
    a, b = views
    p_B = _in_other_view(_true_point(found, errors), X_WA, X_WB)
    n_A = X_WA[:3, :3].T @ X_WB[:3, :3] @ found.normal
    own = (n_A @ found.point) * found.point[2] * stack.deviation[a]
    z = _plane_point(found, p_B)[2]
    other = found.d * z * stack.deviation[b]
    return float(np.sqrt(own**2 + other**2 + FLOOR**2))


def displaced(
    camera: Camera, errors: np.ndarray, p_C: np.ndarray
) -> np.ndarray:
    """Returns a measured point's true position, to first order in the errors.

    Args:
        camera: The camera that measured it.
        errors: Errors that all images share, see `camera_errors`; an empty
            array for an exact camera.
        p_C: The point, shape (3,) [m].
    """
    if len(errors) == 0:
        return p_C
    scale, offset, growth, focal, aspect, center_x, center_y, k1, k2 = errors[
        :9
    ]
    delay, readout = errors[9:11]
    turn_C, shift_C = errors[11:14], errors[14:17]
    z = p_C[2]
    x, y, _ = ray = p_C / z
    deeper = scale * z + offset + growth * z**2
    s = x**2 + y**2
    lens = focal + k1 * s + k2 * s**2
    inwards = np.array([lens * x + center_x, (lens + aspect) * y + center_y, 0])
    row = camera.focal[1] * y + camera.center[1]
    late = delay + readout * (row / camera.height - 0.5)
    moving = camera.v_C + np.cross(camera.omega_C, p_C)
    carried = np.cross(turn_C, p_C) + shift_C
    return p_C + deeper * ray - z * inwards + late * moving + carried


def _camera(stack: ViewStack, view: int) -> Camera:
    return Camera(
        focal=stack.camera[view, :2],
        center=stack.camera[view, 2:],
        height=stack.height[view],
        omega_C=stack.velocity_C[view, :3],
        v_C=stack.velocity_C[view, 3:],
    )


def _scale(errors: np.ndarray) -> float:
    return 1 + float(errors[0]) if len(errors) else 1.0


def _true_point(found: Comparison, errors: np.ndarray) -> np.ndarray:
    return displaced(found.cameras[0], errors, found.point)


def _in_other_view(
    p_A: np.ndarray, X_WA: np.ndarray, X_WB: np.ndarray
) -> np.ndarray:
    p_W = X_WA[:3, :3] @ p_A + X_WA[:3, 3]
    return X_WB[:3, :3].T @ (p_W - X_WB[:3, 3])


def _plane_point(found: Comparison, p_B: np.ndarray) -> np.ndarray:
    """Returns the point where the line of sight to a point hits b's plane."""
    ray = p_B / p_B[2]
    return found.d / (found.normal @ ray) * ray
