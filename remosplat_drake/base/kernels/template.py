"""`Template`: makes equal `Packed` values, each with arrays of its own."""

from collections.abc import Iterator
from typing import Any, Generic

import numpy as np

from remosplat_drake.base.kernels.packed import Packed, Values, _address

_WORD = 8
"""Size of a word of memory [bytes]."""


class Template(Generic[Values]):
    """A named tuple of arrays, of which packed copies are made.

    All arrays of a copy are in one block of memory. So a copy takes much less
    time than packing arrays that are allocated one by one.
    """

    def __init__(self, values: Values):
        """Stores the values.

        Args:
            values: The named tuple of arrays, numbers, and tuples of these.
        """
        self._values, self._places, size = values, [], 0
        addresses, word = [], 0
        for leaf in _leaves(values):
            if not isinstance(leaf, np.ndarray):
                word += 1
                continue
            self._places.append((leaf.shape, leaf.dtype, _WORD * size))
            size += -(-leaf.nbytes // _WORD)
            addresses.append(word)
            word += 1 + 2 * leaf.ndim
        self._block, self._addresses = np.zeros(size, np.int64), addresses
        for own, leaf in zip(
            self._arrays(self._block), self._contents(), strict=True
        ):
            own[...] = leaf
        self._packed: Packed[Values] = Packed(self._placed(self._block))
        self._words = self._packed._words.copy()
        self._words[addresses] -= _address(self._block)

    def copy(self) -> Packed[Values]:
        """Returns the values, packed in new memory."""
        block, words = self._block.copy(), self._words.copy()
        words[self._addresses] += _address(block)
        packed: Packed[Values] = Packed.__new__(Packed)
        packed.values = self._placed(block)
        packed._words, packed.address = words, _address(words)
        packed._layout = self._packed._layout
        packed._numba_type_ = self._packed._numba_type_
        return packed

    def _contents(self) -> Iterator[np.ndarray]:
        return (x for x in _leaves(self._values) if isinstance(x, np.ndarray))

    def _arrays(self, block: np.ndarray) -> Iterator[np.ndarray]:
        """Returns the arrays in a block of memory, in order."""
        return (
            np.ndarray(shape, kind, block, offset)
            for shape, kind, offset in self._places
        )

    def _placed(self, block: np.ndarray) -> Values:
        """Returns the values with their arrays in a block of memory."""
        return _with_arrays(self._values, self._arrays(block))


def _leaves(value: Any) -> Iterator[Any]:
    """Yields the arrays and numbers of nested tuples, in order."""
    if isinstance(value, tuple):
        for part in value:
            yield from _leaves(part)
    else:
        yield value


def _with_arrays(value: Any, arrays: Iterator[np.ndarray]) -> Any:
    """Returns nested tuples with other arrays, in the same order."""
    if isinstance(value, tuple):
        make = getattr(type(value), "_make", tuple)
        return make([_with_arrays(part, arrays) for part in value])
    return next(arrays) if isinstance(value, np.ndarray) else value
