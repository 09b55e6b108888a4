"""A localisation of the base survives the wire, or is refused."""

import numpy as np
import pytest

from remosplat_drake.hardware.wire.localization import (
    BaseFix,
    decode_localization,
    encode_localization,
)
from remosplat_drake.hardware.wire.messages.base_localization import (
    base_localization,
)
from remosplat_drake.hardware.wire.packets import BrokenMessage

FIX = BaseFix(
    np.array([1.0, -2.0, 0.5]),
    np.array([[4.0, 1.0, 0.0], [1.0, 3.0, 0.5], [0.0, 0.5, 1.0]]),
    1_700_000_000.25,
    "map",
    "base_link",
)


def test_a_fix_survives_the_wire():
    fix = decode_localization(encode_localization(FIX))
    np.testing.assert_array_equal(fix.pose, FIX.pose)
    np.testing.assert_array_equal(fix.covariance, FIX.covariance)
    assert fix.stamp == pytest.approx(FIX.stamp, abs=1e-6)
    assert (fix.frame, fix.child_frame) == ("map", "base_link")


@pytest.mark.parametrize(
    ("field", "value", "problem"),
    [
        ("pose", [0.0, np.inf, 0.0], r"pose\[1\] is inf"),
        ("covariance", [np.nan] * 9, r"covariance\[0\] is nan"),
        ("covariance", [1, 2, 0, 0, 1, 0, 0, 0, 1], "not symmetric"),
        ("covariance", [1, 2, 0, 2, 1, 0, 0, 0, 1], "positive"),
    ],
)
def test_a_fix_that_is_none_is_refused(field, value, problem):
    message = base_localization.decode(encode_localization(FIX))
    setattr(message, field, value)
    with pytest.raises(BrokenMessage, match=problem):
        decode_localization(message.encode())


@pytest.mark.parametrize("cut", range(0, 120, 7))
def test_a_packet_that_is_cut_short_is_refused(cut):
    with pytest.raises(BrokenMessage):
        decode_localization(encode_localization(FIX)[:cut])
