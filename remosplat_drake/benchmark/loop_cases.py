"""How well the real-time loop keeps its pace, over a wire to a robot."""

import contextlib
import json
import os
import tempfile
import time
from pathlib import Path

from remosplat_drake.benchmark import hardware_processes as processes
from remosplat_drake.errors import RemoSplatError
from remosplat_drake.real_time import LoopQuality, Spread

RATES = (100.0, 500.0)
"""Control rates that are measured [Hz]."""

DURATION = 8.0
"""How long each of them is driven [s]."""

_START_UP = 60.0


def measure_loop(rate: float, duration: float = DURATION) -> LoopQuality:
    """Drives the default scenario at a rate, and says how the loop was kept.

    The target never counts as reached, so that the run lasts.

    Args:
        rate: Control rate [Hz].
        duration: How long to drive [s].

    Raises:
        RemoSplatError: The run did not get to its end.
    """
    text = (
        f"{{control_period: {1.0 / rate}, time_limit: {duration},"
        " arrival: {position: 1.0e-9}}"
    )
    url = processes.free_url()
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as at:
        log = Path(folder) / "log.jsonl"
        at.enter_context(processes.robot(url))
        run = at.enter_context(
            processes.controller(url, log, "--scenario-text", text)
        )
        end = time.monotonic() + _START_UP + duration
        while run.poll() is None and time.monotonic() < end:
            time.sleep(0.1)
        events = [json.loads(line) for line in log.read_text().splitlines()]
    if not events or "loop" not in events[-1]:
        reasons = [e["reason"] for e in events if e.get("reason")]
        raise RemoSplatError(
            f"the run at {rate:g} Hz did not end: {', '.join(reasons)}"
        )
    return _quality(events[-1]["loop"])


def _quality(values: dict) -> LoopQuality:
    spreads = {
        name: Spread(**values.pop(name)) for name in ("age", "jitter", "work")
    }
    return LoopQuality(**values, **spreads)


def load() -> str:
    """How busy this computer is, as a table's note."""
    return (
        f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}"
        " (processes that want to run, averaged over a minute)"
    )
