"""Ctrl-C (SIGINT) and SIGTERM as a request to stop, not as an exception."""

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopRequest:
    """Whether somebody asked the program to stop.

    Attributes:
        made: Whether a signal has arrived.
        is_heeded: Whether the loop is over. Further signals then change
            nothing, so that none of them strikes in the middle of a ramp to
            standstill.
    """

    def __init__(self):
        self.made = False
        self.is_heeded = False

    def make(self, *_) -> None:
        """Handles a signal: the first one is noted, a second one interrupts.

        Raises:
            KeyboardInterrupt: The program has not looked since the first
                signal.
        """
        if self.made and not self.is_heeded:
            self.is_heeded = True
            raise KeyboardInterrupt
        self.made = True


@contextmanager
def stop_signals(
    numbers: Sequence[signal.Signals] = _SIGNALS,
) -> Iterator[StopRequest]:
    """Handles signals while the block runs.

    A loop looks at the request between two rounds. An exception in the middle
    of a message's delivery would come out of Drake as another one. In a thread
    other than the main one, signals are handled as before, and those that are
    ignored stay ignored.

    Args:
        numbers: The signals, SIGINT and SIGTERM if they are not given.
    """
    request = StopRequest()
    if threading.current_thread() is not threading.main_thread():
        yield request
        return
    before = {
        number: signal.signal(number, request.make)
        for number in numbers
        if signal.getsignal(number) is not signal.SIG_IGN
    }
    try:
        yield request
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def is_interrupt(error: BaseException) -> bool:
    """Whether Ctrl-C is what an exception comes of.

    Compiled code that an interrupt strikes, Numba's for example, may report it
    as a `SystemError` of its own, whose cause it is.
    """
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, KeyboardInterrupt):
        cause = cause.__cause__
    return cause is not None
