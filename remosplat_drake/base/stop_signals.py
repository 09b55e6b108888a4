"""Ctrl-C and the end of a process as a wish to stop, not as an exception."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopRequest:
    """Whether somebody asked the program to stop.

    Attributes:
        made: Somebody did.
        is_heeded: The loop is over; further requests change nothing, so that
            none of them strikes in the middle of a ramp to standstill.
    """

    def __init__(self):
        self.made = False
        self.is_heeded = False

    def make(self, *_) -> None:
        """Notes the first request; a second one interrupts at once.

        Raises:
            KeyboardInterrupt: Somebody asks again, and nobody has looked.
        """
        if self.made and not self.is_heeded:
            self.is_heeded = True
            raise KeyboardInterrupt
        self.made = True


@contextmanager
def stop_signals() -> Iterator[StopRequest]:
    """Lets a loop find out about Ctrl-C or SIGTERM between two rounds.

    An exception in the middle of a message's delivery would come out of
    Drake as another one. Elsewhere than in the main thread nothing changes.
    """
    request = StopRequest()
    if threading.current_thread() is not threading.main_thread():
        yield request
        return
    before = [signal.signal(number, request.make) for number in _SIGNALS]
    try:
        yield request
    finally:
        for number, handler in zip(_SIGNALS, before, strict=True):
            signal.signal(number, handler)
