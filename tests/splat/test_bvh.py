"""The hierarchy: every box below its ancestors, each in exactly one leaf."""

import copy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.splat.bvh import (
    LEAF_SIZE,
    MAX_DEPTH,
    BoundingVolumeHierarchy,
    build_hierarchy,
    leaf_margins,
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
            assert (lower[inside] >= box[0]).all()
            assert (upper[inside] <= box[1]).all()
            assert (center_z[inside] <= top).all()
            seen.extend(range(first, end))
            continue
        for side in range(2):
            child = tree.nodes[link, 6 * side : 6 * side + 6].reshape(2, 3)
            height = tree.nodes[link, 12 + side]
            stack.append(
                (tree.links[link, 14 + side], child, height, depth + 1)
            )
    assert sorted(seen) == list(range(len(lower)))
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


@pytest.mark.parametrize("n", [0, 1, 4, 5, 300])
def test_knows_the_largest_value_below_every_child(n):
    rng = np.random.default_rng(n)
    center, values = rng.normal(size=(n, 3)), rng.exponential(size=n)
    tree = build_hierarchy(center, center, center[:, 2])
    sorted_values, largest = leaf_margins(tree, values)
    np.testing.assert_array_equal(sorted_values, values[tree.order])

    def below(link: int) -> float:
        if link < 0:
            first, end = leaf_range(link)
            return sorted_values[first:end].max(initial=0.0)
        children = [below(child) for child in tree.links[link, 14:]]
        np.testing.assert_array_equal(largest[link], children)
        return max(children)

    assert below(0) == values.max(initial=0.0)
    assert [len(array) for array in leaf_margins(tree, None)] == [0, 0]


def test_is_shared_and_read_only():
    tree = check(np.zeros((9, 3)), np.ones((9, 3)))
    assert copy.deepcopy(tree) is tree
    assert len(tree) == 9
    with pytest.raises(ValueError, match="read-only"):
        tree.nodes[0, 0] = 1
    with pytest.raises(ValueError, match="read-only"):
        tree.links[0, 0] = 1
