"""Ctrl-C while a command's modules are being imported."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_deferred() -> Iterator[None]:
    """Defers Ctrl-C until the end of the block.

    If the import of a compiled module is interrupted, the module reports that
    it is broken. Outside of the main thread, and if another handler is
    installed, this block has no effect.
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
