"""The kernels of a look, against what they stand for in NumPy."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from room import LEFT, Watch
from scipy.spatial.distance import cdist

from remosplat_drake.detection.kernels.near_any import near_any
from remosplat_drake.detection.kernels.robot_mask import robot_mask

SEEDS = st.integers(0, 2**32 - 1)


@given(SEEDS, st.integers(0, 20), st.integers(0, 20))
def test_points_are_near_what_is_within_its_reach(seed, n, m):
    rng = np.random.default_rng(seed)
    p, q = rng.uniform(0, 1, (n, 3)), rng.uniform(0, 1, (m, 3))
    reach = rng.uniform(0, 0.4, m)
    expected = (cdist(p, q) <= reach).any(axis=1) if m else np.zeros(n, bool)
    assert near_any(p, q, reach).tolist() == expected.tolist()


def test_a_point_is_near_where_it_is():
    p = np.array([[1.0, 2.0, 3.0]])
    assert near_any(p, p, np.zeros(1)).tolist() == [True]


def lookup(image, p_W) -> tuple[np.ndarray, float]:
    """What `DepthImage.depths_at` says of one point, in plain words."""
    p_C = image.X_WC[:3, :3].T @ (p_W - image.X_WC[:3, 3])
    if p_C[2] <= 1e-6:
        return p_C, np.nan
    u, v, _ = image.K @ p_C / p_C[2]
    height, width = image.depth.shape
    if not (0 <= u < width and 0 <= v < height):
        return p_C, np.nan
    shown = image.depth[int(v), int(u)]
    return p_C, min(float(shown), image.far) if shown > 0 else np.nan


@given(SEEDS)
@settings(max_examples=30)
def test_a_point_is_looked_up_at_its_pixel(seed):
    watch = Watch([LEFT])
    image = watch.see(0.0)[0].image
    p_W = np.random.default_rng(seed).uniform(-3, 3, (50, 3))
    p_C, measured = image.depths_at(p_W)
    for i, p in enumerate(p_W):
        expected, shown = lookup(image, p)
        np.testing.assert_allclose(p_C[i], expected, atol=1e-12)
        np.testing.assert_equal(measured[i], shown)
    assert not np.isnan(measured).all()


@given(SEEDS)
def test_a_pixel_may_show_a_sphere_that_its_ray_has_met(seed):
    """Points along the ray up to the depth, closely one after the other."""
    rng = np.random.default_rng(seed)
    balls_C = np.append(rng.uniform(-1, 2, 3), rng.uniform(0.05, 1))[None]
    p_C = np.append(rng.uniform(-1, 1, 2), rng.uniform(0.2, 3))
    slack, margin = rng.uniform(0, 0.1), rng.uniform(0, 0.1)
    ray = p_C / p_C[2]
    z = np.linspace(0, 5, 2001)
    apart = np.linalg.norm(z[:, None] * ray - balls_C[0, :3], axis=1)
    within = apart - balls_C[0, 3] - margin <= 0
    found = robot_mask(p_C[None], p_C[2:], np.array([slack]), balls_C, margin)[
        0
    ]
    near = np.abs(apart - balls_C[0, 3] - margin).min() < 2e-2
    if within[0]:
        # The camera is in it: the robot ends where the ray comes out.
        leaves = z[np.flatnonzero(within)[-1]]
        expected = p_C[2] - slack <= leaves
        near = abs(p_C[2] - slack - leaves) < 1e-2
    else:
        met = within & (z > 0)
        expected = bool(met.any()) and z[met.argmax()] <= p_C[2] + slack
        near &= not met.any() or met.sum() < 20
        near |= bool(met.any()) and abs(z[met.argmax()] - p_C[2] - slack) < 1e-2
    assert found == expected or near


def test_the_robot_hides_what_is_behind_it_and_not_beside_it():
    ball_C = np.array([[0.0, 0.0, 1.0, 0.2]])

    def mask(p_C, measured) -> bool:
        points = np.array([p_C], float)
        return bool(
            robot_mask(points, np.array([measured]), np.zeros(1), ball_C, 0.0)
        )

    assert mask([0, 0, 2], 0.9)
    assert not mask([0, 0, 2], 0.7)  # Something is before it.
    assert not mask([1, 0, 2], 2.0)
    inside_C = np.array([[0.0, 0.0, 0.1, 0.2]])
    depths = np.array([0.25, 0.35])
    points = np.tile([0.0, 0.0, 1.0], (2, 1))
    found = robot_mask(points, depths, np.zeros(2), inside_C, 0.0)
    assert found.tolist() == [True, False]
