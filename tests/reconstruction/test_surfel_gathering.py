"""The kernels equal their reference; votes by hand on a step."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.reconstruction.surfels import (
    surfel_gathering,
    surfel_gathering_reference,
)
from remosplat_drake.reconstruction.surfels.surfel_extent import find_extents
from remosplat_drake.reconstruction.surfels.surfel_gathering import (
    COLOR_SUMS,
    GRID,
    PLANE_SUMS,
    DepthNoise,
    DepthView,
    Patches,
    gather_votes,
)
from remosplat_drake.splat.quaternions import rotation_matrices

NOISE = DepthNoise(1e-3, 2e-3, 0.1, 0.1)


def bumpy_view(rng: np.random.Generator) -> DepthView:
    """A rough surface about a metre away, with holes in it."""
    depth = rng.uniform(0.95, 1.05, (24, 32)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.2] = 0
    return DepthView(
        depth,
        rng.integers(0, 256, (24, 32, 3), np.uint8),
        np.array([40.0, 42.0]),
        np.array([16.0, 12.0]),
        rotation_matrices(np.array([[0.98, 0.1, -0.1, 0.14]]))[0],
        rng.normal(0, 0.05, 3),
    )


def patches_before(view: DepthView, rng: np.random.Generator) -> Patches:
    """Patches around the surface, some beside the image or turned away."""
    n = 20
    p_CK = rng.uniform([-0.5, -0.4, 0.9], [0.5, 0.4, 1.1], (n, 3))
    quaternions = rng.normal(size=(n, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    return Patches(
        p_CK @ view.R_WC.T + view.p_WC,
        rotation_matrices(quaternions),
        rng.uniform(0.02, 0.3, n),
        rng.random((n, 3)),
    )


@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1))
def test_kernels_equal_their_reference(seed):
    rng = np.random.default_rng(seed)
    view = bumpy_view(rng)
    patches = patches_before(view, rng)
    n = len(patches.p_WK)
    for function, shapes in (
        ("gather_planes", [(n, PLANE_SUMS), (n, COLOR_SUMS)]),
        ("gather_votes", [(n, GRID, GRID), (n, GRID, GRID)]),
    ):
        fast = [np.zeros(shape) for shape in shapes]
        slow = [np.zeros(shape) for shape in shapes]
        arguments = (patches, view, NOISE, 0.02)
        getattr(surfel_gathering, function)(*arguments, *fast)
        getattr(surfel_gathering_reference, function)(*arguments, *slow)
        for a, b in zip(fast, slow, strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9)


def test_most_random_patches_are_seen():
    """Otherwise the equality above would say nothing."""
    seen = 0
    for seed in range(10):
        rng = np.random.default_rng(seed)
        view = bumpy_view(rng)
        patches = patches_before(view, rng)
        n = len(patches.p_WK)
        planes, colors = np.zeros((n, PLANE_SUMS)), np.zeros((n, COLOR_SUMS))
        surfel_gathering.gather_planes(
            patches, view, NOISE, 0.02, planes, colors
        )
        seen += planes.any()
    assert seen >= 7


@pytest.mark.parametrize("shift", [-0.004, 0.0, 0.007])
def test_the_edge_of_a_table_is_found(shift):
    """Half the image shows a table 1 m below the camera, half the floor.

    The table ends at x = 0. One patch at x = -10 mm with a window of 30 mm
    has the edge at +10 mm; moved along the edge's normal, it moves with it.
    """
    depth = np.full((400, 400), 1.0, np.float32)
    depth[:, 200:] = 1.7
    view = DepthView(
        depth,
        np.zeros((400, 400, 3), np.uint8),
        np.array([1000.0, 1000.0]),
        np.array([200.0, 200.0]),
        np.eye(3),
        np.zeros(3),
    )
    facing = np.diag([1.0, -1, -1])[None]
    patches = Patches(
        np.array([[-0.01 + shift, 0, 1.0]]),
        facing,
        np.array([0.03]),
        np.zeros((1, 3)),
    )
    solid, free = np.zeros((2, 1, GRID, GRID))
    gather_votes(patches, view, NOISE, 0.005, solid, free)
    extents = find_extents(solid, free, patches.radius)
    edge = extents.edge[0]
    assert np.isfinite(edge).sum() == 1
    assert edge.min() == pytest.approx(0.01 - shift, abs=1.5e-3)
    assert extents.solid[0] > 0.5 > extents.free[0]
