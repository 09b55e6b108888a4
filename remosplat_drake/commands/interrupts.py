"""Defers Ctrl-C while a command's modules are imported."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_deferred() -> Iterator[None]:
    """Defers Ctrl-C until the end of the block.

    If Ctrl-C interrupted the import of a compiled module, Python would report
    that the module is broken. Outside the main thread, or if another handler of
    Ctrl-C is installed, Ctrl-C is not deferred.
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
