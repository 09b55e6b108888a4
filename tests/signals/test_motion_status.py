"""`MotionStatus` keeps only its own data in memory."""

import numpy as np

from remosplat_drake.signals.motion_status import HELD, MotionStatus


def test_it_keeps_no_array_of_which_its_point_is_a_part():
    p_WC = np.arange(240.0).reshape(-1, 3)
    status = MotionStatus(HELD, "", p_W=p_WC[7])
    assert status.p_W is not None and status.p_W.base is None
    np.testing.assert_array_equal(status.p_W, [21.0, 22.0, 23.0])
