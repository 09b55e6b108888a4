"""An operator who lets every robot go as soon as it waits for that."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from remosplat_drake.acceptance.consent import Consent


@contextmanager
def consenting(url: str) -> Iterator[None]:
    """Arms all controllers on a wire, in a thread of its own."""
    consent, over = Consent(url), threading.Event()

    def give() -> None:
        while not over.wait(0.02):
            consent.give()

    thread = threading.Thread(target=give)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
