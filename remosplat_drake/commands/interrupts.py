"""Ctrl-C while a command's modules are being imported."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_deferred() -> Iterator[None]:
    """Keeps Ctrl-C waiting until the end of the block.

    A compiled module that is interrupted in the middle of its import reports
    that it is broken. Elsewhere than in the main thread, and where another
    handler has the signal, nothing changes.
    """
    default = signal.default_int_handler
    if (
        threading.current_thread() is not threading.main_thread()
        or signal.getsignal(signal.SIGINT) is not default
    ):
        yield
        return
    waiting = []
    signal.signal(signal.SIGINT, lambda *received: waiting.append(received))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, default)
    if waiting:
        raise KeyboardInterrupt
