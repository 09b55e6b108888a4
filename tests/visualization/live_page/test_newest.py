"""Updates that a visitor gets of values that change faster than it draws."""

import time
from threading import Thread

from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.visualization.live_page.newest import Newest

NAMES = st.sampled_from(["bar", "pose", "plot"])
CHANGES = st.lists(st.tuples(NAMES, st.integers(0, 3)), max_size=20)


@given(st.lists(CHANGES, max_size=6))
def test_an_onlooker_of_any_speed_ends_with_the_newest(groups):
    """It asks after each group, and has then what was put last."""
    dut, seen, latest, version = Newest(), {}, {}, 0
    for group in groups:
        for name, value in group:
            dut.put((name,), value)
            latest[name] = value
        version, changes = dut.after(version)
        assert len(changes) <= len(latest)
        seen.update({key[0]: value for key, value in changes})
        assert seen == latest
    assert dut.after(version) == (version, [])


def test_a_value_that_stays_is_not_sent_again():
    dut = Newest()
    dut.put(("bar",), "moving")
    version, _ = dut.after(0)
    dut.put(("bar",), "moving")
    assert dut.after(version) == (version, [])


def test_a_question_is_answered_when_there_is_news():
    dut, answers = Newest(), []
    asks = Thread(target=lambda: answers.append(dut.after(0, patience=60.0)))
    asks.start()
    dut.put(("bar",), "held")
    asks.join()
    assert answers == [(1, [(("bar",), "held")])]


def test_a_question_without_news_is_answered_in_the_end():
    begin = time.monotonic()
    assert Newest().after(0, patience=0.05) == (0, [])
    assert time.monotonic() - begin >= 0.05


def test_what_was_removed_is_not_sent_to_those_who_come_later():
    dut = Newest()
    for path in ("/trace/0", "/trace/1", "/hand"):
        dut.put(("pose", path), b"")
    dut.put(("bar",), "moving")
    dut.drop(("pose", "/trace"))
    assert [key for key, _ in dut.after(0)[1]] == [("pose", "/hand"), ("bar",)]
    assert dut.of_kind("pose") == {("pose", "/hand"): b""}
