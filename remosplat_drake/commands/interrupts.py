"""Defers Ctrl-C while a command's modules are imported."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_deferred() -> Iterator[None]:
    """Defers Ctrl-C until the end of the block.

    An interrupted import of a compiled module would report a broken module.
    Outside the main thread, or if another handler is installed, the block has
    no effect.
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
