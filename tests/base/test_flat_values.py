"""Values that are taken apart and put together again."""

import dataclasses as dc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.base.flat_values import digest, flatten, restore


@dc.dataclass(frozen=True)
class Leaf:
    number: float
    name: str | None = None


@dc.dataclass(frozen=True)
class Tree:
    leaves: list[Leaf]
    path: tuple[int, ...]
    grown: bool
    points: np.ndarray | None = None


def test_comes_back_bit_for_bit():
    points = np.array([[0.1, -0.0, np.nan], [np.inf, 1e-310, 2 / 3]])
    tree = Tree(
        [Leaf(0.1 + 0.2, "ä"), Leaf(float("nan"))], (1, 2), True, points
    )
    text, arrays = flatten(tree)
    again = restore(Tree, text, arrays)
    assert again.leaves[0] == tree.leaves[0]
    assert np.isnan(again.leaves[1].number) and again.leaves[1].name is None
    assert again.path == (1, 2) and again.grown is True
    assert again.points is not None
    assert again.points.tobytes() == points.tobytes()


@given(st.lists(st.floats(allow_nan=False)), st.integers(-(2**63), 2**63 - 1))
def test_numbers_come_back(numbers, whole):
    tree = Tree([Leaf(x) for x in numbers], (whole,), False)
    text, arrays = flatten(tree)
    assert restore(Tree, text, arrays) == tree
    assert not arrays


def test_a_digest_tells_values_apart():
    zeros = np.zeros(4)
    values = [
        zeros,
        zeros.astype(np.float32),
        np.zeros((2, 2)),
        np.array([0, 0, 0, -0.0]),
        [0.0],
        (0.0,),
        0,
        None,
        Leaf(0.0),
        Leaf(0.0, "a"),
    ]
    assert len({digest(value) for value in values}) == len(values)
    # The layout in memory is none of its business.
    square = np.arange(4.0).reshape(2, 2)
    assert digest(square) == digest(np.asfortranarray(square))


def test_only_declared_dataclasses_are_made():
    text, arrays = flatten(Leaf(1.0))
    with pytest.raises(TypeError, match="expected Tree"):
        restore(Tree, text, arrays)
    with pytest.raises(LookupError):
        restore(Leaf, text.replace("Leaf", "Tree"), arrays)
    with pytest.raises(TypeError, match="cannot store a value of type set"):
        flatten({1})
