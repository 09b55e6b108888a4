"""The hierarchy: every box below its ancestors, each in exactly one leaf."""

import copy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.base import threads
from remosplat_drake.splat import bvh_build
from remosplat_drake.splat.bvh import (
    LEAF_SIZE,
    MAX_DEPTH,
    BoundingVolumeHierarchy,
    are_sound,
    build_hierarchy,
    leaf_range,
)


def check(lower: np.ndarray, upper: np.ndarray) -> BoundingVolumeHierarchy:
    """Builds and walks a hierarchy, asserting everything a query relies on."""
    center_z = 0.5 * (lower[:, 2] + upper[:, 2])
    tree = build_hierarchy(lower, upper, center_z)
    np.testing.assert_array_equal(np.sort(tree.order), np.arange(len(lower)))
    everywhere = np.repeat([[-np.inf], [np.inf]], 3, axis=1)
    stack = [(0, everywhere, np.inf, 0)]
    seen = []
    while stack:
        link, box, top, depth = stack.pop()
        assert depth < MAX_DEPTH
        if link < 0:
            first, end = leaf_range(link)
            assert end - first <= LEAF_SIZE
            inside = tree.order[first:end]
            # All boxes above hold them, not the last one alone.
            assert (lower[inside] >= box[0]).all()
            assert (upper[inside] <= box[1]).all()
            assert (center_z[inside] <= top).all()
            seen.extend(range(first, end))
            continue
        for side in range(2):
            child = tree.nodes[link, 6 * side : 6 * side + 6].reshape(2, 3)
            least, most = np.maximum(child[0], box[0]), child[1]
            within = np.stack([least, np.minimum(most, box[1])])
            height = min(top, tree.nodes[link, 12 + side])
            stack.append(
                (tree.links[link, 14 + side], within, height, depth + 1)
            )
    assert sorted(seen) == list(range(len(lower)))
    assert are_sound(tree.nodes, tree.order, len(lower))
    return tree


@pytest.mark.parametrize("n", [1, LEAF_SIZE, LEAF_SIZE + 1, 2000])
def test_holds_every_box_once(n):
    rng = np.random.default_rng(n)
    center = rng.normal(size=(n, 3))
    half = 10 ** rng.uniform(-6, 0, (n, 3))
    check(center - half, center + half)


@settings(max_examples=30)
@given(
    st.integers(1, 60),
    st.sampled_from([0.0, 1e-30, 1.0, 1e6]),
    st.integers(0, 1000),
)
def test_survives_degenerate_boxes(n, spread, seed):
    rng = np.random.default_rng(seed)
    center = np.round(rng.normal(size=(n, 3))) * spread
    half = rng.choice([0.0, 1e-12, 1.0, 1e4], (n, 3))
    check(center - half, center + half)


def test_is_shallow_even_when_space_shrinks_geometrically():
    # Each cut in space would peel off a few points only.
    center = np.repeat(0.5 ** np.arange(900.0)[:, None], 3, axis=1)
    check(center, center)


def test_holds_boxes_that_reach_beyond_single_precision():
    center = np.random.default_rng(0).normal(size=(40, 3))
    half = np.full((40, 3), 0.01)
    half[::7] = 1e300
    center[3] = [3e38, -3e38, 0]
    check(center - half, center + half)


@pytest.mark.parametrize("outliers", [0, 20])
def test_is_the_same_with_any_number_of_threads(monkeypatch, outliers):
    rng = np.random.default_rng(0)
    center = rng.normal(size=(3000, 3))
    # Far from all others, as in real captures: cut off one by one.
    center[:outliers] = 10.0 ** rng.uniform(1, 30, (outliers, 3))
    whole = check(center, center)
    monkeypatch.setattr(bvh_build, "PIECE", 100)
    for count in (1, 4):
        monkeypatch.setattr(threads, "num_threads", lambda n=count: n)
        parts = check(center, center)
        np.testing.assert_array_equal(parts.links, whole.links)
        np.testing.assert_array_equal(parts.order, whole.order)


def _sound_arrays() -> tuple[np.ndarray, np.ndarray]:
    center = np.random.default_rng(0).normal(size=(300, 3))
    tree = build_hierarchy(center, center, center[:, 2])
    return tree.nodes.copy(), tree.order.copy()


@pytest.mark.parametrize("row", [0, 1, 20, -1])
@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize(
    "change",
    [
        lambda link: -link,
        lambda link: link + 1,
        lambda link: link - 1,
        lambda link: 0,
        lambda link: 2**31 - 1,
        lambda link: -(2**31),
    ],
)
def test_a_wrong_link_is_found(row, side, change):
    nodes, order = _sound_arrays()
    links = nodes.view(np.int32)
    links[row, 14 + side] = change(int(links[row, 14 + side]))
    assert not are_sound(nodes, order, 300)


def test_what_is_no_hierarchy_of_so_many_boxes_is_found():
    nodes, order = _sound_arrays()
    assert are_sound(nodes, order, 300)
    assert are_sound(nodes, order.astype(np.int32), 300)
    assert not are_sound(nodes, order[1:], 300)
    assert not are_sound(nodes, order[1:], 299)
    assert not are_sound(nodes[:-1], order, 300)
    assert not are_sound(nodes[:0], order, 300)
    assert not are_sound(np.vstack([nodes, nodes[-1:]]), order, 300)
    assert not are_sound(nodes[:, :8], order, 300)
    assert not are_sound(nodes.astype(np.float64), order, 300)
    assert not are_sound(nodes, order.astype(np.float64), 300)
    for wrong in (-1, 300, order[1]):
        assert not are_sound(nodes, np.array([wrong, *order[1:]]), 300)


def test_a_hierarchy_that_is_too_deep_is_found():
    # Each node has one box on its left, and all others on its right.
    n = MAX_DEPTH + 2
    nodes = np.zeros((n - 1, 16), np.float32)
    links = nodes.view(np.int32)
    links[:, 14] = -1 - (16 * np.arange(n - 1) + 1)
    links[:, 15] = np.arange(1, n)
    links[-1, 15] = -1 - (16 * (n - 1) + 1)
    assert not are_sound(nodes, np.arange(n), n)
    links[-2, 15] = -1 - (16 * (n - 2) + 2)
    assert are_sound(nodes[:-1], np.arange(n), n)


def test_is_shared_and_read_only():
    tree = check(np.zeros((9, 3)), np.ones((9, 3)))
    assert copy.deepcopy(tree) is tree
    assert len(tree) == 9
    with pytest.raises(ValueError, match="read-only"):
        tree.nodes[0, 0] = 1
    with pytest.raises(ValueError, match="read-only"):
        tree.links[0, 0] = 1
