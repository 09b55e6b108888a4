"""Planes under pixels, on planes and cylinders that are known."""

import numpy as np
import pytest

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.tangent_planes import (
    fit_planes,
    planes_under,
)

K = np.array([[200.0, 0, 80], [0, 200.0, 60], [0, 0, 1]])
SIZE = 120, 160


def rays() -> np.ndarray:
    """Directions of unit depth through all pixels, (h, w, 3)."""
    v, u = np.indices(SIZE) + 0.5
    x, y = (u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1]
    return np.stack([x, y, np.ones(SIZE)], axis=-1)


def depth_of(plane: np.ndarray) -> np.ndarray:
    """Depth of the plane a X + b Y + c Z = 1."""
    return (1 / (rays() @ plane)).astype(np.float32)


@pytest.mark.parametrize("plane", [[0, 0, 0.5], [0.3, -0.2, 0.7]])
def test_a_plane_is_found_exactly(plane):
    plane = np.array(plane)
    row, column = np.array([20, 60, 90]), np.array([30, 80, 140])
    found, roughness = fit_planes(K, depth_of(plane), row, column)
    np.testing.assert_allclose(found, np.tile(plane, (3, 1)), atol=1e-5)
    assert (roughness < 1e-4).all()


def test_a_cylinder_does_not_seem_thinner():
    """The mean of a window would lie within it, a tenth of a millimetre."""
    radius, distance = 0.1, 1.0
    ray = rays()
    # Where z ray is radius away from the axis x = 0, z = distance.
    a, b = ray[..., 0] ** 2 + 1, -2 * distance
    root = b**2 - 4 * a * (distance**2 - radius**2)
    z = np.where(root > 0, (-b - np.sqrt(np.maximum(root, 0))) / (2 * a), 0)
    plane, _ = fit_planes(K, z, np.array([60]), np.array([80]))
    found = 1 / (plane[0] @ rays()[60, 80])
    assert found == pytest.approx(z[60, 80], abs=1e-5)


def test_edges_unknown_pixels_and_grazing_views_have_no_plane():
    depth = np.stack([depth_of(np.array([0, 0, 0.5]))] * 2)
    depth[0, :, 80:] = 3.0
    depth[0, 30, 30] = 0
    # Seen at 4 degrees from the right of the image on.
    depth[1] = depth_of(np.array([10.0, 0, 5]))
    capture = Capture(
        np.stack([K, K]),
        np.stack([np.eye(4)] * 2),
        np.zeros((2, *SIZE, 3), np.uint8),
        depth,
    )
    pixels = np.array([[30, 60], [80, 60], [30, 30], [1, 60]])
    direction = np.column_stack([(pixels + 0.5 - K[:2, 2]) / 200, np.ones(4)])
    found = planes_under(capture, 0, 2 * direction)
    assert np.isfinite(found.plane[:, 0]).tolist() == [True] + 3 * [False]
    np.testing.assert_allclose(found.p_C[0], 2 * direction[0], atol=1e-6)
    np.testing.assert_allclose(found.normal_C[0], [0, 0, 1], atol=1e-6)
    grazing = planes_under(capture, 1, 0.1 * direction[:1])
    assert np.isnan(grazing.plane).all()
