"""The wide hierarchy holds all boxes, and finds the near ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.lanes import lowest_bit
from remosplat_drake.oracle.kernels.near_children import (
    around,
    lowered,
    near_children,
    node_address,
    raised,
)
from remosplat_drake.oracle.kernels.wide_tree import (
    ROWS,
    WIDTH,
    largest_below,
    widen,
)
from remosplat_drake.splat.bvh import (
    LEAF_SIZE,
    build_hierarchy,
    leaf_range,
)
from remosplat_drake.splat.bvh_build import leaf_link


@kernel
def look(wide, node, p, limit, floor):
    """The bits and the squared distances of a node's children."""
    squares = np.empty(WIDTH, np.float32)
    x, x_up, y, y_up, z, z_up = around((p[0], p[1], p[2]))
    bits = near_children(  # pyright: ignore[reportCallIssue]
        node_address(wide, node),
        x,
        x_up,
        y,
        y_up,
        z,
        z_up,
        raised(limit),
        lowered(floor),
        squares.ctypes.data,
    )
    return bits, squares


@kernel
def places(bits):
    """The places of the bits that are set."""
    found = []
    while bits:
        found.append(lowest_bit(bits))
        bits &= bits - 1
    return found


def some_boxes(rng, n: int) -> np.ndarray:
    lower = rng.uniform(-1, 1, (n, 3)) * rng.choice([0.01, 1.0, 100.0])
    upper = lower + rng.uniform(0, 0.2, (n, 3))
    center = 0.5 * (lower + upper)[:, 2]
    return np.column_stack([lower, upper, center, np.arange(n)])


def distance_squared(boxes: np.ndarray, p: np.ndarray) -> np.ndarray:
    off = np.maximum(boxes[:, :3] - p, p - boxes[:, 3:6]).clip(0.0)
    return (off**2).sum(axis=1)


def boxes_of_leaves(children, boxes) -> dict[tuple[int, int], np.ndarray]:
    """What each leaf of a wide hierarchy holds, by its node and place."""
    places = np.argwhere(children < 0).tolist()
    spans = [leaf_range(int(children[i, k])) for i, k in places]
    return {
        (i, k): boxes[first:end]
        for (i, k), (first, end) in zip(places, spans, strict=True)
    }


@pytest.mark.parametrize("n", [1, 2, 4, 5, 8, 9, 30, 1000, 4096])
def test_every_box_is_in_it_once_and_within_all_above(n):
    boxes = some_boxes(np.random.default_rng(n), n)
    if n == 4096:  # In a row, and so halved evenly: more nodes than usual.
        boxes[:, :6] = 0.0
        boxes[:, 0] = boxes[:, 3] = np.arange(n)
    tree = build_hierarchy(boxes[:, :3], boxes[:, 3:6], boxes[:, 6])
    boxes = boxes[tree.order]
    wide, children = widen(tree.nodes, tree.links, LEAF_SIZE)
    assert (len(wide) > len(tree.nodes) // 3 + 9) == (n == 4096)
    assert wide.shape[1:] == (ROWS, WIDTH) and children.shape[1:] == (WIDTH,)
    held = boxes_of_leaves(children, boxes)
    seen, waiting = 0, [(0, [])]
    while waiting:
        node, above = waiting.pop()
        for k in range(WIDTH):
            child, box = children[node, k], wide[node, :, k]
            if np.isnan(box[0]):
                assert child == 0 and np.isnan(box).all()
            elif child > 0:
                waiting.append((child, [*above, box]))
            else:
                inner = held[node, k]
                seen += len(inner)
                for outer in [*above, box]:
                    assert (outer[:3] <= inner[:, :3]).all()
                    assert (outer[3:] >= inner[:, 3:7]).all()
    assert seen == sum(map(len, held.values())) == n
    assert len(wide) <= max(1, 0.6 * len(tree.nodes))


@given(
    st.integers(0, 10**9),
    st.sampled_from([0.0, 1e-20, 0.01, 1.0, np.inf]),
    st.sampled_from([-np.inf, -0.2, 0.0, 0.3]),
)
@settings(max_examples=300, deadline=None)
def test_no_near_child_is_missed_and_few_far_ones_are_taken(seed, reach, floor):
    rng = np.random.default_rng(seed)
    boxes = some_boxes(rng, rng.integers(1, 60))
    tree = build_hierarchy(boxes[:, :3], boxes[:, 3:6], boxes[:, 6])
    boxes = boxes[tree.order]
    wide, children = widen(tree.nodes, tree.links, LEAF_SIZE)
    # What lies on a box's border counts as near.
    p = rng.choice([rng.uniform(-1, 1, 3), boxes[0, :3], boxes[-1, 3:6]])
    for (node, place), inner in boxes_of_leaves(children, boxes).items():
        bits, squares = look(wide, node, p, reach**2, floor)
        is_in = place in places(bits) if bits else False
        square = distance_squared(inner, p)
        if len(inner):
            assert squares[place] <= square.min() * (1 + 1e-6)
        if ((square <= reach**2) & (inner[:, 6] >= floor)).any():
            assert is_in
        outer = wide[node, :, place].astype(float)
        away = np.sqrt(distance_squared(outer[None], p)[0])
        slack = 1e-4 * (1 + np.abs(p).max())
        if away > reach + slack or outer[6] < floor - slack:
            assert not is_in


def test_bits_are_found_from_the_lowest_on():
    assert places(0b10110001) == [0, 4, 5, 7]


@pytest.mark.parametrize("n", [0, 1, 4, 5, 8, 9, 300])
def test_leaves_hold_up_to_eight_boxes_and_largest_values_are_known(n):
    rng = np.random.default_rng(n)
    boxes, values = some_boxes(rng, n), rng.exponential(size=n)
    tree = build_hierarchy(boxes[:, :3], boxes[:, 3:6], boxes[:, 6])
    values = values[tree.order]
    wide, children = widen(tree.nodes, tree.links, WIDTH)
    spans = sorted(leaf_range(link) for link in children[children < 0].tolist())
    ends = [0, *(end for _, end in spans)]
    assert [first for first, _ in spans] == ends[:-1] and ends[-1] == n
    assert all(end - first <= WIDTH for first, end in spans)
    usual, _ = widen(tree.nodes, tree.links, LEAF_SIZE)
    assert len(wide) < len(usual) if n >= 30 else len(wide) <= len(usual)
    largest = largest_below(children, values)

    def below(link: int) -> float:
        if link < 0:
            first, end = leaf_range(link)
            return values[first:end].max(initial=0.0)
        found = [
            0.0 if np.isnan(wide[link, 0, k]) else below(child)
            for k, child in enumerate(children[link].tolist())
        ]
        np.testing.assert_array_equal(largest[link], found)
        return max(found)

    assert below(0) == values.max(initial=0.0)


@given(st.integers(0, 2**26), st.integers(0, 15))
def test_leaf_links_name_their_boxes(first, n):
    assert leaf_range(leaf_link(first, first + n)) == (first, first + n)
