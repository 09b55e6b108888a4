"""`row_arrays`: clearances as kernels take them."""

import numpy as np

from remosplat_drake.signals.compiled_map import RowArrays
from remosplat_drake.signals.distance_field import Clearances


def row_arrays(rows: Clearances) -> RowArrays:
    """Returns clearances packed for kernels.

    Args:
        rows: The clearances. Their arrays are copied, since numba compiles
            anew for arrays that may not be written.
    """
    return RowArrays(
        np.array(rows.sphere, np.int64),
        np.array(rows.distance, float),
        np.array(rows.direction_W, float),
        np.array(rows.p_WC, float),
    )
