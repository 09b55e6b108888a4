"""Shorthands for the result types of kernels; see `Kernel.returns`."""

from numba import types

REAL, WHOLE, TRUTH, NOTHING = (
    types.float64,
    types.int64,
    types.boolean,
    types.none,
)


def reals(n: int) -> types.Array:
    """Returns the type of arrays of real numbers of n dimensions."""
    return types.Array(REAL, n, "C")


def wholes(n: int) -> types.Array:
    """Returns the type of arrays of integers of n dimensions."""
    return types.Array(WHOLE, n, "C")


def truths(n: int) -> types.Array:
    """Returns the type of arrays of booleans of n dimensions."""
    return types.Array(TRUTH, n, "C")


def several(*kinds: types.Type) -> types.BaseTuple:
    """Returns the type of tuples of some types."""
    return types.BaseTuple.from_types(kinds)


def named(kind: type, *kinds: types.Type) -> types.BaseNamedTuple:
    """Returns the type of named tuples.

    Args:
        kind: The class.
        kinds: The types of its fields.
    """
    if len(set(kinds)) == 1:
        return types.NamedUniTuple(kinds[0], len(kinds), kind)
    return types.NamedTuple(kinds, kind)
