"""Distance to unseen voxels: by hand, by trying all, by its derivatives."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle import unknown_space_reference as reference
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
from remosplat_drake.oracle.voxel_octree import child_masks, level_table
from remosplat_drake.robot.sphere_model import Spheres


def room(size: int = 11) -> np.ndarray:
    """Seen voxels; nothing is known outside."""
    return np.zeros((size,) * 3, bool)


def with_one(i: int, j: int, k: int) -> UnknownSpaceField:
    """Voxels of 1 m around the origin, the one at (i, j, k) unseen."""
    unseen = room()
    unseen[i, j, k] = True
    return UnknownSpaceField(unseen, np.full(3, -5.5), 1.0)


def one_row(dut: UnknownSpaceField, p_WS, radius=0.0, **options):
    answer = dut.clearances(Spheres.at(p_WS, radius, **options))
    assert len(answer) == 1
    return answer.distance[0], answer.direction_W[0], answer.p_WC[0]


@pytest.mark.parametrize(
    ("p_WS", "radius", "distance", "direction", "point"),
    [
        # The voxel spans [1.5, 2.5] x [-0.5, 0.5]^2.
        ([0, 0, 0], 0, 1.5, [1, 0, 0], [1.5, 0, 0]),
        ([0, 0.3, -0.2], 0.5, 1.0, [1, 0, 0], [1.5, 0.3, -0.2]),
        ([2, 0, 2], 0, 1.5, [0, 0, -1], [2, 0, 0.5]),
        ([2, 0, -2], 0, 1.5, [0, 0, 1], [2, 0, -0.5]),
        ([-1.5, 4.5 - 1, 0.1], 0, 2.0, [0, 1, 0], [-1.5, 5.5, 0.1]),
        # At an edge, along a diagonal.
        (
            [0.5, 1.5, 0],
            0,
            np.sqrt(2),
            [0.5**0.5, -(0.5**0.5), 0],
            [1.5, 0.5, 0],
        ),
        # Inside, away from the nearest way out, which is to (1.5, 0, 0).
        ([1.7, 0, 0], 0, -0.2, [1, 0, 0], [1.5, 0, 0]),
        ([2, 0.4, 0], 0.1, -0.2, [0, -1, 0], [2, 0.5, 0]),
        # Outside the room nothing was seen.
        ([-7, 0, 0], 0, -1.5, [-1, 0, 0], [-5.5, 0, 0]),
        ([-9.5, 0, 8.5], 0, -5, [-0.8, 0, 0.6], [-5.5, 0, 5.5]),
    ],
)
def test_one_unseen_voxel(p_WS, radius, distance, direction, point):
    answer = one_row(with_one(7, 5, 5), p_WS, radius)
    np.testing.assert_allclose(answer[0], distance, atol=1e-12)
    np.testing.assert_allclose(answer[1], direction, atol=1e-12)
    np.testing.assert_allclose(answer[2], point, atol=1e-12)


def test_rows_at_the_queried_distance_or_beyond_are_left_out():
    dut = with_one(7, 5, 5)
    spheres = Spheres.at([[0, 0, 0], [1, 0, 0], [2, 0, 0]], 0.25)
    np.testing.assert_array_equal(dut.clearances(spheres, 0.25).sphere, [2])
    np.testing.assert_array_equal(dut.clearances(spheres, 0.251).sphere, [1, 2])
    np.testing.assert_array_equal(
        dut.clearances(spheres, 1.251).sphere, range(3)
    )
    assert len(dut.clearances(spheres, -1.0)) == 0


def test_each_sphere_ignores_the_voxels_below_its_own_height():
    dut = with_one(5, 5, 5)
    spheres = Spheres.at(np.tile([[0, 0, 1]], (4, 1)))
    # The voxel's centre is at height 0; below all there is the floor.
    spheres.ignore_below[:] = [-np.inf, 0, 0.01, 20]
    answer = dut.clearances(spheres)
    np.testing.assert_array_equal(answer.sphere, [0, 1, 2])
    np.testing.assert_allclose(answer.distance, [0.5, 0.5, 4.5])
    # In an unseen voxel, the way out may lead below that height.
    distance, direction, _ = one_row(dut, [0, 0, -0.4], ignore_below=-0.2)
    np.testing.assert_allclose(distance, -0.1)
    np.testing.assert_allclose(direction, [0, 0, 1])
    below = one_row(dut, [0, 0, -3], ignore_below=0.01)
    np.testing.assert_allclose(below[0], np.hypot(5.5, 3.5))


def test_on_the_boundary_the_direction_points_into_the_unknown():
    distance, direction, _ = one_row(with_one(7, 5, 5), [1.5, 0, 0])
    assert distance == pytest.approx(0)
    np.testing.assert_allclose(direction, [1, 0, 0])


def test_a_grid_must_be_one_and_hold_something_seen():
    with pytest.raises(RemoSplatError, match="no voxel of the grid"):
        UnknownSpaceField(~room(2), np.zeros(3), 1.0)
    with pytest.raises(RemoSplatError, match="not a grid of voxels"):
        UnknownSpaceField(room()[0], np.zeros(3), 1.0)
    with pytest.raises(RemoSplatError, match="not a grid of voxels"):
        UnknownSpaceField(room(), np.zeros(3), 0.0)


def test_an_undefined_sphere_is_refused():
    dut = with_one(7, 5, 5)
    with pytest.raises(ValueError, match="not finite"):
        dut.clearances(Spheres.at([np.nan, 0, 0]))


def test_equal_grids_have_equal_revisions():
    dut = with_one(7, 5, 5)
    assert dut.revision == with_one(7, 5, 5).revision
    assert dut.revision != with_one(7, 5, 6).revision
    assert copy.deepcopy(dut) is dut


def test_a_pickled_field_answers_the_same():
    dut = with_one(7, 5, 5)
    copied = pickle.loads(pickle.dumps(dut))
    spheres = Spheres.at([[0, 0, 0], [2, 0, 0]])
    np.testing.assert_array_equal(
        copied.clearances(spheres).distance, dut.clearances(spheres).distance
    )


@pytest.mark.parametrize("shape", [(1, 1, 1), (2, 5, 3), (8, 1, 9)])
def test_an_octree_says_which_blocks_hold_which_kind(shape):
    unseen = np.random.default_rng(0).random(shape) < 0.3
    unseen = np.pad(unseen, 1, constant_values=True)
    levels, children = level_table(unseen.shape), child_masks(unseen)
    expected = []
    for level in range(1, len(levels)):
        assert levels[level, 0] == len(expected)
        half, count = 1 << (level - 1), -(-np.array(unseen.shape) >> level)
        np.testing.assert_array_equal(levels[level, 1:], count[1:])
        for node in np.ndindex(*count):
            row = [0, 0]
            for bit, child in enumerate(np.ndindex(2, 2, 2)):
                start = half * (2 * np.array(node) + child)
                block = unseen[tuple(slice(a, a + half) for a in start)]
                row[0] |= int((~block).any()) << bit
                row[1] |= int(block.any()) << bit
            expected.append(row)
    np.testing.assert_array_equal(children, expected)
    assert len(children) - levels[-1, 0] == 1


GRIDS = {
    "seed": st.integers(0, 1000),
    "fraction": st.sampled_from([0.0, 0.01, 0.3, 0.9]),
    "floor": st.sampled_from([-np.inf, 0.0, 0.13, 5.0]),
}


def random_grid(rng, fraction):
    shape = rng.integers(1, 8, 3)
    unseen = rng.random(shape) < fraction
    unseen[tuple(rng.integers(0, shape))] = False
    lower, voxel = rng.uniform(-0.5, 0, 3), rng.uniform(0.05, 0.3)
    p_WS = lower + rng.uniform(-1, shape + 1, (40, 3)) * voxel
    return unseen, lower, voxel, p_WS


@settings(max_examples=60)
@given(**GRIDS)
def test_equals_trying_all_voxels(seed, fraction, floor):
    rng = np.random.default_rng(seed)
    unseen, lower, voxel, p_WS = random_grid(rng, fraction)
    spheres = Spheres.at(p_WS, 0.0, floor)
    expected = reference.signed_distances(unseen, lower, voxel, spheres)
    dut = UnknownSpaceField(unseen, lower, voxel)
    answer = dut.clearances(spheres)
    np.testing.assert_allclose(
        answer.per_sphere(len(p_WS)), expected, atol=1e-12
    )
    offset = answer.p_WC - p_WS[answer.sphere]
    np.testing.assert_allclose(
        np.linalg.norm(offset, axis=1), np.abs(answer.distance), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.norm(answer.direction_W, axis=1), 1)
    near = dut.clearances(spheres, 0.2)
    np.testing.assert_array_equal(near.sphere, np.flatnonzero(expected < 0.2))


@settings(max_examples=40)
@given(**GRIDS)
def test_the_distance_is_lipschitz_and_the_direction_its_derivative(
    seed, fraction, floor
):
    rng = np.random.default_rng(seed)
    unseen, lower, voxel, p_WS = random_grid(rng, fraction)
    dut = UnknownSpaceField(unseen, lower, voxel)
    step = rng.normal(size=p_WS.shape)
    step *= 1e-7 / np.linalg.norm(step, axis=1, keepdims=True)
    here = dut.clearances(Spheres.at(p_WS, 0.0, floor))
    there = dut.clearances(Spheres.at(p_WS + step, 0.0, floor))
    change = there.distance - here.distance
    assert (np.abs(change) <= 1.000001e-7).all()
    slope = -(here.direction_W * step[here.sphere]).sum(axis=1)
    # Where two boundaries are equally near the derivative jumps.
    smooth = np.abs(change - slope) < 1e-10
    assert smooth.sum() >= 0.9 * len(smooth)
