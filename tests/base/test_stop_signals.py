"""Signals to this very process, as a loop sees them."""

import os
import signal
import threading

import pytest

from remosplat_drake.base.stop_signals import stop_signals


@pytest.fixture(autouse=True)
def heard():
    """Ctrl-C is heard, even where the suite runs in a shell's background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_first_signal_is_a_request(number):
    before = signal.getsignal(number)
    with stop_signals() as request:
        assert not request.made
        os.kill(os.getpid(), number)
        assert request.made
    assert signal.getsignal(number) is before


def test_the_second_one_interrupts_at_once():
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt), stop_signals():
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before


def test_nothing_interrupts_what_follows_the_loop():
    with stop_signals() as request:
        os.kill(os.getpid(), signal.SIGINT)
        request.has_ended = True
        for number in (signal.SIGINT, signal.SIGTERM):
            os.kill(os.getpid(), number)
    assert request.made


def test_only_one_of_many_signals_interrupts():
    with stop_signals():
        os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)


def test_another_thread_has_no_signals():
    seen = []

    def work():
        with stop_signals() as request:
            seen.append(request.made)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [False]


def test_what_is_ignored_stays_ignored():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with stop_signals() as request:
            os.kill(os.getpid(), signal.SIGINT)
            assert not request.made
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


def test_other_signals_are_left_alone():
    before = signal.getsignal(signal.SIGTERM)
    with stop_signals([signal.SIGINT]):
        assert signal.getsignal(signal.SIGTERM) is before
