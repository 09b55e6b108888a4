"""Arrays of splats that are made block by block, on several threads.

What is made in many steps is faster in blocks: they stay in a core's cache from
step to step, and nothing but the result takes new memory.
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
        n: Number of rows, of splats.
        part: Makes some rows of all arrays, the same whatever rows are made
            with them.

    Returns:
        The arrays by their names, single precision.

    Raises:
        RemoSplatError: What `part` raises for all rows at once, since messages
            count all of them.
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
