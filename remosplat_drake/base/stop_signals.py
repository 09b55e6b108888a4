"""Ctrl-C (SIGINT) and SIGTERM as a request to stop, not as an exception."""

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopRequest:
    """A request to stop the program, made by a signal.

    Attributes:
        made: Whether a signal has arrived.
        is_heeded: Whether the loop has ended. Further signals are then ignored,
            so that none interrupts a ramp to standstill.
    """

    def __init__(self):
        self.made = False
        self.is_heeded = False

    def make(self, *_) -> None:
        """Handles a signal: records the first one; a second one interrupts.

        Raises:
            KeyboardInterrupt: The program has not reacted to the first signal.
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

    A loop checks the request between two iterations. An exception during the
    delivery of a message would leave Drake as another exception. In a thread
    other than the main one, signal handling does not change. Ignored signals
    stay ignored.

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
    """Whether an exception was caused by Ctrl-C.

    Interrupted compiled code, Numba's for example, may raise a `SystemError`
    whose cause is the interrupt.
    """
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, KeyboardInterrupt):
        cause = cause.__cause__
    return cause is not None
