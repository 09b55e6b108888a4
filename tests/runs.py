"""Helpers of the tests that drive whole scenarios or real processes."""

import re
import resource
import subprocess
import sys
from pathlib import Path

from patience import PATIENCE

from remosplat_drake.app.diagram import Application, build
from remosplat_drake.app.run_result import RunResult
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import load_world
from remosplat_drake.commands.main import USER_ERROR, main


def load_application(spec: str | Path, text: str = "") -> Application:
    """The diagram of a scenario, with `text` laid over it."""
    scenario = load_scenario(str(spec), text)
    return build(scenario, load_world(scenario))


def run_scenario(spec: str | Path, text: str = "") -> RunResult:
    """Drives a scenario to its end."""
    return run(load_application(spec, text))


PATIENT = """
hardware: {connect_timeout: 300, arm_status_expiry: 0.5,
  hand_status_expiry: 1, base_status_expiry: 0.5, base_latency: 0.5,
  base_delay: 0.5, base_share: 0.5, frozen_after: 1}
supervisor: {max_status_age: 0.5, max_tick_age: 0.5, max_overrun: 0.5,
  follow_dwell: 2, max_tracking_error: 10}
"""
"""Overrides of a scenario on a wire: as patient as a real robot allows.

The machine that runs the tests may be busy. What a late tick does is the
supervisor's business, and tested there.
"""

PROGRESS = r"[\w -]+: (\d+ (s|min)|\d+ of \d+(, about \d+ (s|min) left)?)$"
"""A line that says how far a program is, where there is no terminal."""

SAY_STARTED = "SAY_STARTED"
"""Environment of a process that prints this when Python itself has started."""

# A shell's background job ignores Ctrl-C, and so would its children.
_LAUNCHER = f"""
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from remosplat_drake.commands.main import main
if "{SAY_STARTED}" in os.environ:
    print("{SAY_STARTED}", flush=True)
sys.exit(main())
"""


def command_line(*arguments: str | Path) -> list[str]:
    """What starts `remosplat` in a process of its own."""
    return [sys.executable, "-c", _LAUNCHER, *map(str, arguments)]


def remosplat(
    *arguments: str | Path,
    cwd: Path | None = None,
    largest_file: int | None = None,
) -> subprocess.CompletedProcess[str]:
    """Runs `remosplat` in a process of its own and waits for it.

    `largest_file` is where its disk is full [bytes]: no file of it and of its
    children grows beyond.
    """

    def fill_disk() -> None:
        if largest_file is not None:
            _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
            resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, hard))

    return subprocess.run(
        command_line(*arguments),
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        preexec_fn=fill_disk,
    )


def complaint(capsys, *arguments: str | Path) -> str:
    """A user's mistake, made in this process: the one line that names it."""
    assert main([*map(str, arguments)]) == USER_ERROR
    captured = capsys.readouterr()
    assert captured.out == ""
    return _only_line(captured.err)


def assert_one_line(result: subprocess.CompletedProcess[str], *mentions: str):
    """A user's mistake: exit code 2, one line, all mentions in it.

    What the program says of its start and its map is no complaint.
    """
    assert result.returncode == USER_ERROR, result.stderr
    assert result.stdout == ""
    line = _only_line(result.stderr)
    assert all(mention in line for mention in mentions), line


def _only_line(text: str) -> str:
    """The one line that is a complaint."""
    said = re.compile("map: |map error: |unseen: |" + PROGRESS)
    lines = [line for line in text.splitlines() if not said.match(line)]
    assert len(lines) == 1, text
    assert lines[0].startswith("remosplat: ")
    return lines[0]


def address(process: subprocess.Popen[str]) -> str:
    """Where the process says that its page is."""
    assert process.stderr is not None
    for line in process.stderr:
        if line.startswith("operate at"):
            return line.split()[2].rstrip(";")
    raise AssertionError("the process has gone")
