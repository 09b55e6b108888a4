"""The version of the map in use, on the wire."""

import pytest

from remosplat_drake.hardware.wire.counting import (
    EXPIRY,
    CountingMap,
    decode_counting,
    encode_counting,
)
from remosplat_drake.hardware.wire.packets import BrokenMessage

NOW = 1_700_000_000.0


def test_what_counts_survives_the_wire():
    said = CountingMap(3, "ellipsoids-0123")
    assert decode_counting(encode_counting(said, NOW), NOW) == said


@pytest.mark.parametrize("late", [-1.1 * EXPIRY, 1.1 * EXPIRY])
def test_an_old_message_and_one_from_the_future_tell_nothing(late):
    data = encode_counting(CountingMap(3, "a"), NOW)
    assert decode_counting(data, NOW + late) is None


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"nonsense" * 4,
        encode_counting(CountingMap(-1, "a"), NOW),
        encode_counting(CountingMap(1, ""), NOW),
        encode_counting(CountingMap(1, "a"), NOW)[:-3],
    ],
)
def test_what_names_no_map_is_refused(data):
    with pytest.raises(BrokenMessage):
        decode_counting(data, NOW)
