"""A stream of stamps on a time line drawn by hand."""

import pytest

from remosplat_drake.hardware.client.stream import (
    Stream,
    StreamLimits,
    advanced,
    broken,
    stream_problem,
)

LIMITS = StreamLimits(expiry=0.05, frozen_after=0.2)
EXPIRY = LIMITS.expiry


def steady(until: float, changing: bool = True) -> Stream:
    """Messages every 10 ms from t = 0, each 1 ms under way."""
    stream = Stream()
    for i in range(round(until / 0.01) + 1):
        t = 0.01 * i
        stream = advanced(stream, t, t + 0.001, changing, EXPIRY)
    return stream


def problem(stream: Stream, now: float, should_change: bool = True) -> str:
    return stream_problem(stream, now, LIMITS, should_change)


def test_a_steady_stream_is_fine():
    assert problem(steady(1.0), 1.002) == ""


def test_before_the_first_message():
    assert problem(Stream(), 5.0) == "nothing came yet"


def test_silence():
    assert problem(steady(1.0), 1.049) == ""
    assert problem(steady(1.0), 1.051) == "nothing came for 50 ms"
    assert problem(steady(1.0), 1.061) == "nothing came for 60 ms"
    assert problem(steady(1.0), 3.001) == "nothing came for 2 s"


def test_delay():
    """Every message is 80 ms under way: no jump, only old."""
    stream = Stream()
    for i in range(20):
        stream = advanced(stream, 0.01 * i, 0.01 * i + 0.08, True, EXPIRY)
    assert problem(stream, 0.27) == "stamped 80 ms ago"


def test_stamps_that_stand_still():
    stream = steady(1.0)
    for i in range(10):
        stream = advanced(stream, 1.0, 1.01 + 0.01 * i, True, EXPIRY)
    assert problem(stream, 1.1) == "stamped 100 ms ago"


@pytest.mark.parametrize(
    ("jump", "words"),
    [
        (1.0, "jumped by 1 s"),
        (-1.0, "jumped by -1 s"),
        (0.2, "jumped by 200 ms"),
    ],
)
def test_a_clock_that_is_set(jump, words):
    stream = steady(1.0)
    for i in range(1, 5):
        t = 1.0 + 0.01 * i
        stream = advanced(stream, t + jump, t + 0.001, True, EXPIRY)
    assert words in problem(stream, 1.042)


def test_a_clock_that_is_set_and_set_back():
    stream = steady(1.0)
    stream = advanced(stream, 2.01, 1.011, True, EXPIRY)
    stream = advanced(stream, 1.02, 1.021, True, EXPIRY)
    assert problem(stream, 1.022) == ""


def test_a_jump_that_is_over_is_not_the_cause_of_later_delays():
    stream = steady(1.0)
    stream = advanced(stream, 1.01, 1.161, True, EXPIRY)
    assert "jumped by -150 ms" in problem(stream, 1.162)
    stream = advanced(stream, 1.17, 1.171, True, EXPIRY)
    assert problem(stream, 1.172) == ""
    for i in range(1, 10):
        t = 1.17 + 0.01 * i
        stream = advanced(stream, t, t + 0.01 * i, True, EXPIRY)
    assert problem(stream, 1.351) == "stamped 91 ms ago"


def test_a_clock_that_has_always_been_ahead():
    stream = advanced(Stream(), 11.0, 1.0, True, EXPIRY)
    assert problem(stream, 1.0) == "stamped 10 s in the future: set the clocks"


def test_a_driver_that_comes_back_is_no_jump():
    stream = advanced(steady(1.0), 9.0, 9.001, True, EXPIRY)
    assert problem(stream, 9.002) == ""


def test_frozen_content_with_fresh_stamps():
    stream = steady(1.0)
    for i in range(1, 31):
        t = 1.0 + 0.01 * i
        stream = advanced(stream, t, t + 0.001, False, EXPIRY)
    assert problem(stream, 1.302) == "frozen for 301 ms"
    assert problem(stream, 1.302, should_change=False) == ""


def test_a_broken_message_is_told_until_a_good_one():
    stream = broken(steady(1.0), 1.011, "joint_position[3] is nan")
    assert problem(stream, 1.012) == "joint_position[3] is nan"
    stream = advanced(stream, 1.02, 1.021, True, EXPIRY)
    assert problem(stream, 1.022) == ""
