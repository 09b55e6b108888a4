"""What is said while kernels are compiled, in processes of their own."""

import importlib
import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher
from patience import PATIENCE
from runs import command_line

from remosplat_drake.app.compiling import SECONDS

JOB = """
import numpy as np
from rich.console import Console
from remosplat_drake.app import compiling
from remosplat_drake.base.progress import Progress
from remosplat_drake.robot import kinematics
from remosplat_drake.controller.verification.kernels import places

compiling.SECONDS = {
    "robot.kinematics.advance": 1.0,
    "controller.verification.kernels.places.chain": 1.0,
    "of.a.module.that.nothing.imports": 100.0,
}
q, u = np.zeros(1), np.ones((1, 1))
with Progress(Console()) as progress, compiling.compiling_shown(progress):
    kinematics.advance(q, u[0], 0, 1.0)
    places.chain(q, u, np.ones(1), 0)
"""
"""Needs two kernels."""


def said(cache: Path) -> str:
    """What the job says on stderr."""
    result = subprocess.run(
        [sys.executable, "-c", JOB],
        env=os.environ | {"NUMBA_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert result.stdout == ""
    return result.stderr


def test_it_is_said_wherever_kernels_are_missing(tmp_path):
    for cache in ("one", "another"):
        assert "compiling kernels: 0 of 2" in said(tmp_path / cache)
        assert said(tmp_path / cache) == ""


def test_what_is_on_disk_does_not_count(tmp_path):
    said(tmp_path)
    for path in tmp_path.rglob("places.chain*"):
        path.unlink()
    assert "compiling kernels: 0 of 1" in said(tmp_path)


def test_a_bar_in_a_terminal(tmp_path):
    terminal, theirs = pty.openpty()
    environment = {"TERM": "xterm", "COLUMNS": "100"}
    with subprocess.Popen(
        [sys.executable, "-c", JOB],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        env=os.environ | environment | {"NUMBA_CACHE_DIR": str(tmp_path)},
    ) as process:
        os.close(theirs)
        text = ""
        while data := _read(terminal):
            text += data.decode()
        assert process.wait() == 0
    os.close(terminal)
    assert re.search("compiling kernels.*━.*0 of 2, about", text)
    assert re.search("compiling kernels.*━.*1 of 2, about", text)
    assert "2 of 2" not in text


def _read(terminal: int) -> bytes:
    try:
        return os.read(terminal, 4096)
    except OSError:  # The process has closed its end.
        return b""


def test_what_is_waited_for_are_kernels():
    for name in SECONDS:
        module, _, function = name.rpartition(".")
        found = importlib.import_module(f"remosplat_drake.{module}")
        assert isinstance(getattr(found, function), Dispatcher)


@pytest.mark.slow
def test_a_first_run_says_how_far_it_is(tmp_path):
    """And it needs as many kernels as it says from the beginning on."""
    flags = ["--headless", "--scenario-text", "{time_limit: 0.1}"]
    result = subprocess.run(
        command_line("run", "TableReach", *flags),
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=2 * PATIENCE,
    )
    lines = re.findall(r"compiling kernels: (\d+) of (\d+)", result.stderr)
    counts = [(int(done), int(total)) for done, total in lines]
    assert counts[0][0] == 0
    assert counts == sorted(counts)
    assert all(done < total for done, total in counts)
    # All but the one of the other oracle.
    assert {total for _, total in counts} == {len(SECONDS) - 1}
