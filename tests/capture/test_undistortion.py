"""Undistorted images against a scene seen through the forward model."""

import numpy as np
import pytest

from remosplat_drake.capture.undistortion import (
    Distortion,
    distort,
    undistort,
    valid_radius,
)

SIZE = (60, 80)
K = np.array([[70.0, 0, 41], [0, 72, 29], [0, 0, 1]])
LENS = Distortion(k1=-0.2, k2=0.05, k3=0.01, k4=-0.002, p1=0.004, p2=-0.003)


def rays(K) -> np.ndarray:
    """Where the pixels of a pinhole camera look on z = 1, (h, w, 2)."""
    u, v = np.meshgrid(np.arange(SIZE[1]) + 0.5, np.arange(SIZE[0]) + 0.5)
    return (np.stack([u, v], axis=-1) - K[:2, 2]) / K[[0, 1], [0, 1]]


def undistorted_rays(K, distortion) -> np.ndarray:
    """Where those of a camera with a lens look: the model, inverted."""
    target = rays(K)
    xy = target.copy()
    for _ in range(60):
        xy += target - distort(distortion, xy)
    return xy


def colors_of(xy) -> np.ndarray:
    """A picture painted on the plane z = 1."""
    waves = [
        np.sin(3 * xy[..., 0]),
        np.cos(4 * xy[..., 1]),
        np.sin(5 * xy[..., 0] * xy[..., 1]),
    ]
    return np.rint(127 + 100 * np.stack(waves, axis=-1)).astype(np.uint8)


def depth_of(xy) -> np.ndarray:
    """A pole one metre away before a wall at three."""
    return np.where(np.abs(xy[..., 0] - 0.1) < 0.1, 1, 3).astype(np.float32)


def test_model_by_hand():
    lens = Distortion(k1=0.5, k2=0.25, p1=0.1, p2=0.01)
    # s = 5, radial = 1 + 2.5 + 6.25.
    np.testing.assert_allclose(
        distort(lens, np.array([1.0, 2.0])),
        [9.75 + 0.4 + 0.07, 19.5 + 1.3 + 0.04],
    )


def test_undoes_the_forward_model():
    seen = undistorted_rays(K, LENS)
    hidden = seen[..., 1] > 0.3
    rgb, depth, new_hidden = undistort(
        LENS, K, colors_of(seen), depth_of(seen), hidden
    )
    ideal = rays(K)
    shown = ~new_hidden
    assert shown.mean() > 0.7
    error = np.abs(rgb.astype(int) - colors_of(ideal))[shown]
    assert error.max() <= 3
    assert set(np.unique(depth[shown])) == {1, 3}
    # Depth may differ only where a pixel's ray passes near the pole's edge.
    edge = np.abs(np.abs(ideal[..., 0] - 0.1) - 0.1) < 1.2 / K[0, 0]
    wrong = depth != depth_of(ideal)
    assert not (wrong & shown & ~edge).any()
    assert new_hidden[ideal[..., 1] > 0.32].all()


def test_what_the_lens_did_not_see_is_hidden():
    """A pincushion lens shows less at the corners than a pinhole would."""
    lens = Distortion(k1=0.4)
    ones = np.ones(SIZE, np.float32)
    rgb, depth, hidden = undistort(
        lens, K, np.full((*SIZE, 3), 9, np.uint8), ones, None
    )
    assert hidden[0, 0] and not hidden[30, 40]
    assert (depth[hidden] == 0).all() and (rgb[hidden] == 0).all()
    assert (depth[~hidden] == 1).all()


@pytest.mark.parametrize(
    ("lens", "radius"),
    [(Distortion(), np.inf), (Distortion(k1=-1 / 3), 1.0)],
)
def test_the_polynomial_holds_up_to_where_it_turns(lens, radius):
    assert valid_radius(lens) == pytest.approx(radius)


def test_no_distortion_changes_nothing():
    rng = np.random.default_rng(0)
    image = rng.integers(0, 256, (*SIZE, 3), np.uint8)
    depth = rng.random(SIZE, np.float32)
    rgb, same, hidden = undistort(Distortion(), K, image, depth, None)
    np.testing.assert_array_equal(rgb, image)
    np.testing.assert_array_equal(same, depth)
    assert not hidden.any()
