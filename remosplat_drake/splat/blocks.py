"""Computes arrays of splats block by block, on several threads.

Computations with many steps are faster in blocks, because a block remains in a
core's cache from step to step. Only the result needs new memory.
"""

from collections.abc import Callable, Mapping

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.threads import blocks, in_parallel

_BLOCK = 1 << 14


def in_blocks(
    n: int, part: Callable[[slice], Mapping[str, np.ndarray]]
) -> dict[str, np.ndarray]:
    """Makes arrays of n rows block by block.

    Args:
        n: Number of rows, one for each splat.
        part: Function that computes some rows of all arrays, independent of the
            other rows.

    Returns:
        The arrays by their names, single precision.

    Raises:
        RemoSplatError: `part` failed for some rows. Since messages contain the
            number of invalid rows, `part` is called again for all rows, and
            this call's error is raised.
    """
    arrays: dict[str, np.ndarray] = {}

    def fill(rows: slice) -> None:
        for name, array in part(rows).items():
            arrays[name][rows] = array

    try:
        for name, array in part(slice(0, 1)).items():
            arrays[name] = np.empty((n, *array.shape[1:]), np.float32)
        in_parallel(fill, blocks(n, _BLOCK))
    except RemoSplatError:
        part(slice(0, n))
        raise
    return arrays
