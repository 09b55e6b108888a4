"""Measures the timing of the real-time loop, with a simulated robot on LCM."""

import contextlib
import json
import os
import tempfile
import time
from pathlib import Path

from remosplat_drake.acceptance import hardware_processes as processes
from remosplat_drake.acceptance.consent import Consent
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.real_time import LoopQuality, Spread
from remosplat_drake.signals.supervisor_state import UNARMED

RATES = (100.0, 500.0)
"""Control rates to measure [Hz]."""

TOUR = """
time_limit: 12
targets:
- {translation: [1.15, 0.0, 0.66], rpy_deg: [180, 0, 0]}
- {translation: [0.95, 0.45, 0.95], rpy_deg: [180, 0, 0]}
- {translation: [1.15, 0.0, 0.66], rpy_deg: [180, 0, 0]}
"""
"""Targets of a tour of about 8 s: down to the table, up, and down again."""

SEEN = "PersonSeen"
"""Name of the scenario with cameras."""

_DURATION = 12.0


def measure_loop(rate: float) -> LoopQuality:
    """Measures the loop's timing during a tour in the default scenario.

    Args:
        rate: Control rate [Hz].

    Raises:
        RemoSplatError: The run did not complete.
    """
    text = f"control_period: {1.0 / rate}{TOUR}"
    return _measured(f"at {rate:g} Hz", ["--scenario-text", text])


def measure_detection() -> LoopQuality:
    """Measures the loop's timing near a person that two cameras see.

    Together, the cameras send at most 30 images of 640 x 480 pixels per second.
    Two cameras, the robot, `remosplat detect` and the controller run in five
    processes.

    Raises:
        RemoSplatError: The run did not complete, or no person was detected.
    """
    cameras = load_scenario(SEEN).cameras
    found = _measured(
        "with cameras",
        ["--scenario", SEEN],
        SEEN,
        ["detect", SEEN],
        *(
            ["camera-sim", SEEN, "--camera", camera.name, "--rate", "15"]
            for camera in cameras
        ),
    )
    if found.image_to_command is None:
        raise RemoSplatError("no image has reached a command")
    return found


def _measured(
    what: str, arguments: list[str], scenario: str = "", *beside: list[str]
) -> LoopQuality:
    """Runs a scenario on the simulated robot and measures the loop's timing.

    Args:
        what: Name of the run in messages about failures.
        arguments: Arguments of the controller's process.
        scenario: The scenario of the stand-in robot; if empty, its default.
        beside: Further `remosplat` commands, which run on the same LCM network.
    """
    url = processes.free_url()
    consent = Consent(url)
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as at:
        log = Path(folder) / "log.jsonl"
        at.enter_context(processes.robot(url, *filter(None, [scenario])))
        for line in beside:
            at.enter_context(processes.program(*line, "--lcm-url", url))
        run = at.enter_context(processes.controller(url, log, *arguments))
        longest = processes.START_UP + _DURATION
        end = time.monotonic() + longest
        while run.poll() is None and time.monotonic() < end:
            consent.give()
            time.sleep(0.1)
        processes.end(run)
        events = [json.loads(line) for line in log.read_text().splitlines()]
    reasons = [event["reason"] for event in events if event.get("reason")]
    reasons = [reason for reason in reasons if reason != UNARMED]
    if reasons:
        raise RemoSplatError(f"the run {what} stopped: {', '.join(reasons)}")
    if not events or "loop" not in events[-1]:
        raise RemoSplatError(
            f"the run {what} has not ended within {longest:.0f} s"
        )
    return _quality(events[-1]["loop"])


def _quality(values: dict) -> LoopQuality:
    for name in ("age", "jitter", "work", "busy", "image_to_command"):
        values[name] = values[name] and Spread(**values[name])
    return LoopQuality(**values)


def load() -> str:
    """Returns the load of this computer, as a note below a table."""
    return (
        f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}"
        " (runnable processes, averaged over a minute)"
    )
