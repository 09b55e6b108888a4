"""Turns Ctrl-C (SIGINT) and SIGTERM into a stop request that a loop checks."""

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopRequest:
    """A request to stop the program, made by a signal.

    Attributes:
        made: Whether a signal has arrived.
        has_ended: Whether the loop has ended. After that, signals are ignored,
            so that they do not interrupt the braking ramp.
    """

    def __init__(self):
        self.made = False
        self.has_ended = False

    def make(self, *_) -> None:
        """Records the first signal; a second one raises KeyboardInterrupt.

        Raises: KeyboardInterrupt: The loop has not ended since the first
        signal.
        """
        if self.made and not self.has_ended:
            self.has_ended = True
            raise KeyboardInterrupt
        self.made = True


@contextmanager
def stop_signals(
    numbers: Sequence[signal.Signals] = _SIGNALS,
) -> Iterator[StopRequest]:
    """Records signals as a `StopRequest` while the block runs.

    A loop checks the request between two iterations. The signal handler does
    not raise an exception at the first signal: if it did so while Drake
    delivers a message, Drake would convert the exception into another one.
    Signals that are ignored before the block remain ignored. Outside the main
    thread, the function has no effect.

    Args:
        numbers: The signals; by default SIGINT and SIGTERM.
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
    """Returns whether an exception was caused by Ctrl-C.

    If Ctrl-C interrupts compiled code, for example Numba's, this code may raise
    a `SystemError` whose cause is the KeyboardInterrupt. Such an error counts,
    too.
    """
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, KeyboardInterrupt):
        cause = cause.__cause__
    return cause is not None
