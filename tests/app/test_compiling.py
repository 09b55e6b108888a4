"""Messages while kernels are compiled, in processes of their own."""

import json
import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest
from effort import effort
from patience import PATIENCE
from runs import command_line

from remosplat_drake.app import compiling
from remosplat_drake.base.kernels.listing import listed, read_list

JOB = """
import numpy as np
from rich.console import Console
from remosplat_drake.app import compiling
from remosplat_drake.base.progress import Progress
from remosplat_drake.robot import kinematics
from remosplat_drake.controller.verification.kernels import places

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
    for cache in effort(("one",), ("one", "another")):
        assert "compiling kernels: 0 of 1, about" in said(tmp_path / cache)
        assert said(tmp_path / cache) == ""


@pytest.mark.slow
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
    assert re.search("compiling kernels.*━.*0 of 1, about", text)


def _read(terminal: int) -> bytes:
    try:
        return os.read(terminal, 4096)
    except OSError:  # The process has closed its end.
        return b""


USED = """
import sys
from remosplat_drake.base.kernels import variant
from remosplat_drake.commands.main import main
code = main(["run", "--headless", "--scenario-text", "{time_limit: 0.1}"])
used = [v for v in variant.variants if v.kernel.content and v.uses is not None]
print(*(v.file for v in used))
"""


def test_the_list_holds_what_a_run_needs():
    """If this fails, `make kernels` makes the list anew."""
    result = subprocess.run(
        [sys.executable, "-c", USED], capture_output=True, text=True
    )
    files = {variant.file for variant in read_list(compiling.RUN_KERNELS)}
    *_, used = result.stdout.splitlines()
    assert set(used.split()) <= files


def kernels_of(content: dict) -> set[str]:
    """The kernels of a list, each with the types of its arguments."""

    def told(number):
        row = content["types"][number]
        if isinstance(row, str):
            return row
        what, *rest = row
        if what == "array":
            return f"{told(rest[0])}{rest[1:]}"
        names = [x for x in rest if isinstance(x, str)]
        return f"{names}({', '.join(told(x) for x in rest[len(names) :])})"

    return {
        f"{name}({', '.join(map(told, numbers))})"
        for name, _, *numbers in content["kernels"]
    }


def test_the_list_is_read_as_it_was_written():
    variants = read_list(compiling.RUN_KERNELS)
    content = json.loads(compiling.RUN_KERNELS.read_text())
    assert len(variants) == len(content["kernels"])
    assert kernels_of(json.loads(listed(variants))) == kernels_of(content)


@pytest.mark.slow
def test_a_first_run_says_how_far_it_is(tmp_path):
    """And it needs about as many kernels as it says from the beginning on."""
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
    listed = len(json.loads(compiling.RUN_KERNELS.read_text())["kernels"])
    assert all(0.7 * listed < total < 1.3 * listed for _, total in counts)
