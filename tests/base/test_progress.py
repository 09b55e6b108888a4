"""Progress of a long job, in a real terminal and in real pipes."""

import os
import pty
import re
import subprocess
import sys

import pytest

from remosplat_drake.base import progress
from remosplat_drake.base.progress import Stage

JOB = """
import sys
from rich.console import Console
from remosplat_drake.base import progress

progress.BEGUN = progress.PERIOD = 0.01
with progress.Progress(Console(stderr=sys.argv[1:] == ["stderr"])) as shown:
    input()
    shown.report("reading")
    input()
    shown.report("fitting", 0, 4)
    shown.report("fitting", 1, 4)
    input()
print("done")
"""
"""Goes on with each line that it reads."""


def read_until(descriptor: int, pattern: str) -> str:
    """Reads until there is what a pattern describes, and returns all."""
    text = ""
    while not re.search(pattern, text):
        data = os.read(descriptor, 4096)
        assert data, text
        text += data.decode()
    return text


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_lines_in_a_pipe(stream):
    """On stderr, whichever stream the command prints on."""
    with subprocess.Popen(
        [sys.executable, "-c", JOB, stream],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        assert process.stdin and process.stdout and process.stderr
        said = process.stderr.fileno()

        def go_on() -> None:
            assert process.stdin is not None
            process.stdin.write(b"\n")
            process.stdin.flush()

        go_on()
        text = read_until(said, r"(reading: \d+ s\n){2}")
        go_on()
        text += read_until(said, r"fitting: 1 of 4, about \d+ s left\n")
        go_on()
        text += process.stderr.read().decode()
        line = r"(reading: \d+ s|fitting: 1 of 4, about \d+ s left)\n"
        assert re.fullmatch(f"({line})*", text)
        assert process.stdout.read() == b"done\n"


def test_a_bar_in_a_terminal():
    terminal, theirs = pty.openpty()
    with subprocess.Popen(
        [sys.executable, "-c", JOB],
        stdin=subprocess.PIPE,
        stdout=theirs,
        stderr=theirs,
        env=os.environ | {"TERM": "xterm", "COLUMNS": "100"},
    ) as process:
        os.close(theirs)
        assert process.stdin is not None
        process.stdin.write(b"\n\n")
        process.stdin.flush()
        text = read_until(terminal, "fitting.*━.*1 of 4, about")
        assert ": " not in text
        process.stdin.write(b"\n")
        process.stdin.flush()
        text = read_until(terminal, "done")
        assert re.search(r"\x1b\[2K\s*done", text)  # The line has vanished.
    os.close(terminal)


def test_lines_are_few(monkeypatch):
    """The first at one second; then for a tenth more, or after half a minute.

    The times are those of a clock that the test moves.
    """
    now = [100.0]
    monkeypatch.setattr(progress, "BEGUN", 1.0)
    monkeypatch.setattr(progress, "monotonic", lambda: now[0])
    stage = Stage("fitting", 0, 100, start=now[0])
    told = []
    for second in range(120):
        now[0] = 100.0 + second
        stage.done = {0: 0, 1: 5, 2: 15, 3: 40}.get(second, 45)
        if stage.is_line_due():
            told.append((second, stage.line().split(",")[0]))
    assert told == [
        (1, "fitting: 5 of 100"),
        (6, "fitting: 45 of 100"),
        (36, "fitting: 45 of 100"),
        (66, "fitting: 45 of 100"),
        (96, "fitting: 45 of 100"),
    ]


def test_it_never_goes_back():
    steps = iter([(0.3, 7.0), (0.2, 8.0), (1.5, 0.0)])
    stage = Stage("fitting", 1, 4, lambda: next(steps))
    assert stage.state() == (0.3, "1 of 4, about 7 s left")
    assert stage.state() == (0.3, "1 of 4, about 8 s left")
    assert stage.state() == (1.0, "1 of 4, about 0 s left")


def test_no_estimate_without_a_step():
    fraction, said = Stage("reading").state()
    assert fraction is None and re.fullmatch(r"\d+ s", said)
    assert Stage("fitting", 1, 4).state() == (0.25, "1 of 4")
    fraction, said = Stage("checking", 0, 1).state()
    assert fraction is None and re.fullmatch(r"\d+ s", said)
