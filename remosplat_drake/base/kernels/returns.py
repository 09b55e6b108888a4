"""Functions that return Numba types, to declare the result types of kernels."""

from numba import types

REAL, WHOLE, TRUTH, NOTHING = (
    types.float64,
    types.int64,
    types.boolean,
    types.none,
)


def reals(n: int) -> types.Array:
    """Returns the type of n-dimensional arrays of double-precision numbers."""
    return types.Array(REAL, n, "C")


def wholes(n: int) -> types.Array:
    """Returns the type of n-dimensional arrays of integers."""
    return types.Array(WHOLE, n, "C")


def truths(n: int) -> types.Array:
    """Returns the type of n-dimensional arrays of booleans."""
    return types.Array(TRUTH, n, "C")


def several(*kinds: types.Type) -> types.BaseTuple:
    """Returns the type of tuples whose elements have the given types."""
    return types.BaseTuple.from_types(kinds)


def named(kind: type, *kinds: types.Type) -> types.BaseNamedTuple:
    """Returns the type of a named tuple.

    Args:
        kind: The class of the named tuple.
        kinds: The types of its fields.
    """
    if len(set(kinds)) == 1:
        return types.NamedUniTuple(kinds[0], len(kinds), kind)
    return types.NamedTuple(kinds, kind)
