"""Time limits of tests that wait for other processes."""

import time
from collections.abc import Callable

PATIENCE = 800.0
"""Longest wait for anything, however busy the computer is [s]."""


def wait_for(done: Callable[[], bool]) -> None:
    """Waits until a condition holds."""
    end = time.monotonic() + PATIENCE
    while not done():
        assert time.monotonic() < end, "it does not come to that"
        time.sleep(0.01)
