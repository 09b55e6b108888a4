"""Tests of tubes and triads."""

from collections import Counter

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.visualization.shapes import draw_triad, tube_mesh


def volume(vertices, faces):
    """Divergence theorem; positive when the faces look outwards."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.einsum("fi,fi->", a, np.cross(b, c)) / 6


def test_straight_tube_is_a_prism():
    # A square of circumradius 1 has area 2; the length is 3.
    points = np.array([[0, 0, 0], [0, 0, 1.0], [0, 0, 3.0]])
    vertices, faces = tube_mesh(points, radius=1.0, sides=4)
    np.testing.assert_allclose(np.hypot(*vertices[:, :2].T), 1.0)
    assert sorted(set(vertices[:, 2])) == [0.0, 1.0, 3.0]
    np.testing.assert_allclose(volume(vertices, faces), 6.0)


def test_tube_is_closed():
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 2.0]])
    _, faces = tube_mesh(points, radius=0.1)
    edges = Counter(
        edge for a, b, c in faces for edge in [(a, b), (b, c), (c, a)]
    )
    assert all(edges[b, a] == count == 1 for (a, b), count in edges.items())


@settings(max_examples=30)
@given(st.integers(0, 10**6), st.integers(2, 12))
def test_rings_keep_their_radius_on_any_path(seed, n):
    points = np.random.default_rng(seed).normal(size=(n, 3))
    vertices, _ = tube_mesh(points, radius=0.2)
    offsets = vertices.reshape(n, -1, 3) - points[:, None]
    np.testing.assert_allclose(np.linalg.norm(offsets, axis=2), 0.2)


def test_path_that_turns_back_on_itself_stays_finite():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 0.0]])
    vertices, _ = tube_mesh(points, radius=0.1)
    assert np.isfinite(vertices).all()


def test_triad_axes_point_along_their_frame(page, pose_of):
    draw_triad(page.meshcat, "/frame", length=0.2)
    for i, axis in enumerate("xyz"):
        X = pose_of(page.meshcat, f"/frame/{axis}")
        np.testing.assert_allclose(X[:3, 2], np.eye(3)[i], atol=1e-12)
        np.testing.assert_allclose(X[:3, 3], 0.1 * np.eye(3)[i], atol=1e-12)
