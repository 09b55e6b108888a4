"""`row_arrays`: packs `Clearances` for kernels."""

import numpy as np

from remosplat_drake.signals.compiled_map import RowArrays
from remosplat_drake.signals.distance_field import Clearances


def row_arrays(rows: Clearances) -> RowArrays:
    """Returns `Clearances` as packed `RowArrays` for kernels.

    Args:
        rows: The clearances. Their read-only arrays are copied, since Numba
            would compile the kernels again for read-only arrays.
    """
    return RowArrays(
        np.array(rows.sphere, np.int64),
        np.array(rows.distance, float),
        np.array(rows.direction_W, float),
        np.array(rows.p_WC, float),
    )
