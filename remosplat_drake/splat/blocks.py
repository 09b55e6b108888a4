"""Computes arrays of splats in blocks of rows, on several threads.

A computation with many steps is faster in blocks, because a block remains in
the cache of a processor core from step to step. Memory is allocated only for
the result.
"""

from collections.abc import Callable, Mapping

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.threads import blocks, in_parallel

_BLOCK = 1 << 14


def in_blocks(
    n: int, part: Callable[[slice], Mapping[str, np.ndarray]]
) -> dict[str, np.ndarray]:
    """Makes arrays of n rows, one block of rows at a time.

    Args:
        n: Number of rows, one for each splat.
        part: Function that computes some rows of all arrays. These rows must
            not depend on other rows.

    Returns:
        The arrays in single precision, keyed by name.

    Raises:
        RemoSplatError: `part` has failed for some rows. `part` is then called
            again for all rows, and the error of this call is raised, since its
            message contains the number of invalid rows.
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
