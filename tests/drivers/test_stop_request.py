"""The first signal is noted, the second one interrupts."""

import os
import signal

import pytest

from remosplat_drake.drivers.stop_request import StopRequest


@pytest.fixture(autouse=True)
def handlers():
    before = {n: signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_is_noted_and_the_next_one_interrupts(number):
    stop = StopRequest()
    assert not stop.received
    os.kill(os.getpid(), number)
    assert stop.received
    with pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), number)
