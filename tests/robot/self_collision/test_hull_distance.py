"""The compiled distance of convex hulls, against two slow references."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from remosplat_drake.robot.self_collision.hull_distance_reference import (
    signed_distance,
)
from remosplat_drake.robot.self_collision.kernels.gjk import hull_distance
from remosplat_drake.robot.self_collision.pair_arrays import vertex_blocks

measured = hull_distance

CUBE = np.array(
    [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float
)


def measure(A, B, R=None, p=(0, 0, 0), *, guess=(1.0, 0, 0), enough=np.inf):
    """The distance of two hulls, its direction, and the nearest points."""
    A, B = np.array(A, float), np.array(B, float)
    R, p = np.eye(3) if R is None else R, np.array(p, float)
    work = np.zeros((3, 4, 3)), np.zeros(4), np.zeros(3), np.zeros((2, 3))
    A, B = vertex_blocks(A), vertex_blocks(B)
    spans = (0, len(A)), (len(A), len(A) + len(B))
    hulls = np.concatenate([A, B]), *spans, np.ascontiguousarray(R), p
    distance, *n = measured(hulls, guess, enough, work)
    return distance, np.array(n), work[-1]


def is_proved(A, B, distance, n):
    """No vertices, and so no points, are nearer to each other along n."""
    return (B @ n).min() - (A @ n).max() >= distance - 1e-9


@st.composite
def two_hulls(draw):
    """Two random polyhedra or boxes, somewhere, often face to face."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    kind = draw(st.sampled_from(["points", "boxes", "aligned", "slabs"]))
    if kind == "points":
        A, B = (
            rng.normal(size=(rng.integers(4, 25), 3))
            * rng.uniform(0.02, 0.3, 3)
            for _ in range(2)
        )
    else:
        A, B = (CUBE * rng.uniform(0.02, 0.3, 3) for _ in range(2))
    if kind == "slabs":
        A[:, 2] *= 1e-3
    R = Rotation.random(rng=rng).as_matrix()
    p = rng.uniform(-0.4, 0.4, 3)
    if kind == "aligned":
        R = Rotation.from_euler("z", 90 * rng.integers(4), degrees=True)
        R, p = R.as_matrix(), np.round(p, 1)
    return A, B @ R.T + p


@given(hulls=two_hulls())
@settings(max_examples=60)
def test_it_is_the_distance_or_the_depth(hulls):
    A, B = hulls
    distance, n, (p, q) = measure(A, B)
    assert distance == pytest.approx(signed_distance(A, B), abs=2e-7)
    assert is_proved(A, B, distance, n)
    assert np.linalg.norm(n) == pytest.approx(1.0)
    np.testing.assert_allclose(q - p, distance * n, atol=2e-6)


@given(
    hulls=two_hulls(),
    depth=st.sampled_from([-1e-3, -1e-6, -1e-9, 0.0, 1e-9, 1e-6, 1e-3]),
)
@settings(max_examples=60)
def test_hulls_that_nearly_touch_are_told_apart(hulls, depth):
    """One is moved along the normal until a chosen distance is left."""
    A, B = hulls
    distance, n, _ = measure(A, B)
    B = B + (depth - distance) * n
    found, n, _ = measure(A, B)
    assert is_proved(A, B, found, n)
    if depth >= 0.0:
        assert found == pytest.approx(depth, abs=1e-8)
    else:  # Elsewhere they are less deep, and two tips may miss each other.
        assert depth - 1e-8 <= found
        assert found == pytest.approx(signed_distance(A, B), abs=2e-7)


@given(
    hulls=two_hulls(),
    guess=st.tuples(*3 * [st.floats(-1, 1)]),
    enough=st.floats(0.0, 0.5),
)
@settings(max_examples=60)
def test_what_is_enough_comes_sooner_and_is_a_lower_bound(hulls, guess, enough):
    A, B = hulls
    exact, _, _ = measure(A, B)
    found, n, _ = measure(A, B, guess=guess, enough=enough)
    assert is_proved(A, B, found, n)
    if exact <= enough:
        assert found == pytest.approx(exact, abs=1e-9)
    else:
        assert enough < found <= exact + 1e-12


def test_hulls_as_deep_along_several_directions_have_points_along_theirs():
    for size in ([1, 1, 1], [0.2, 1, 1], [0.2, 0.2, 1]):
        distance, n, (p, q) = measure(CUBE, CUBE * size)
        np.testing.assert_allclose(q - p, distance * n, atol=1e-9)


def test_a_pose_moves_the_second_hull():
    R = Rotation.from_euler("xyz", (0.3, -0.4, 1.1)).as_matrix()
    p = np.array([0.5, 0.1, -0.2])
    A, B = 0.1 * CUBE, CUBE * [0.05, 0.1, 0.2]
    moved, n, points = measure(A, B, R, p)
    expected = measure(A, B @ R.T + p)
    assert moved == pytest.approx(expected[0])
    np.testing.assert_allclose(n, expected[1], atol=1e-12)
    np.testing.assert_allclose(points, expected[2], atol=1e-12)


@pytest.mark.parametrize(
    ("A", "B", "expected"),
    [
        # Corners, edges and faces of boxes; points, segments.
        (CUBE, np.add(CUBE, [4, 3, 0]), np.hypot(2, 1)),
        (CUBE, np.add(CUBE, [3, 0, 0]), 1.0),
        (CUBE, np.add(CUBE, [3, 3, 3]), np.sqrt(3)),
        (CUBE, np.add(CUBE, [2, 0, 0]), 0.0),
        (CUBE, np.add(CUBE, [1.5, 0.2, 0.1]), -0.5),
        (CUBE, CUBE, -2.0),
        (CUBE, [[0, 0, 0]], -1.0),
        (CUBE, [[0, 0, 3]], 2.0),
        ([[0, 0, 0]], [[3, 4, 0]], 5.0),
        ([[0, 0, 0]], [[0, 0, 0]], 0.0),
        ([[-1, 0, 0], [1, 0, 0]], [[0, -1, 2], [0, 1, 2]], 2.0),
        ([[-1, 0, 0], [1, 0, 0]], [[0, -1, 0], [0, 1, 0]], 0.0),
        (CUBE, [[0, 0, -3], [0, 0, 3]], -1.0),
    ],
)
def test_by_hand(A, B, expected):
    assert measure(A, B)[0] == pytest.approx(expected, abs=1e-9)
