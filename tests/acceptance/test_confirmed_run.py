"""`remosplat run --hardware --accept` at a terminal, as in a lab."""

import json
import os
import pty
import subprocess
from collections.abc import Callable
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from patience import PATIENCE
from runs import PATIENT, command_line

from remosplat_drake.acceptance.hardware_processes import end, free_url, robot
from remosplat_drake.base.resources import models_dir
from remosplat_drake.reconstruction.report.quality_report import (
    QualityReport,
    write_report,
)

TABLE = models_dir() / "scenes" / "table"


@pytest.fixture
def scenario(tmp_path) -> Path:
    """The shipped table, said to be wrong by 30 mm."""
    splat = tmp_path / "splat.ply"
    splat.write_bytes((TABLE / "splat.ply").read_bytes())
    seen = TABLE / "splat.seen"
    (tmp_path / seen.name).write_bytes(seen.read_bytes())
    write_report(splat, QualityReport(map_error=0.03))
    path = tmp_path / "table.yaml"
    path.write_text(
        "Table:\n"
        f"  scene: {{splat: splat.ply, truth: {TABLE / 'scene.json'}}}\n"
        "  time_limit: 0.5\n"
    )
    return path


@contextmanager
def terminal(*arguments: str | Path):
    """A process at a pseudo-terminal of its own, and the other end of it."""
    ours, theirs = pty.openpty()
    with subprocess.Popen(
        command_line(*arguments), stdin=theirs, stdout=theirs, stderr=theirs
    ) as process:
        os.close(theirs)
        try:
            yield process, ours
        finally:
            process.terminate()
            os.close(ours)


def read(terminal: int, done: Callable[[bytes], bool]) -> bytes:
    """Reads what is on the screen until it suffices, or to its end."""
    text = b""
    # The end is an error where the other end of a terminal is closed.
    with suppress(OSError):
        while not done(text):
            text += os.read(terminal, 4096)
    return text


@pytest.mark.slow
def test_a_confirmed_run_is_driven_and_kept(wire, scenario, tmp_path):
    url, output = free_url(), tmp_path / "out"
    flags = (
        *("--lcm-url", url, "--output", output, "--accept", "map-error"),
        *("--scenario-text", PATIENT),
    )
    with (
        robot(url) as stand_in,
        terminal(
            "run",
            scenario,
            "--hardware",
            "--headless",
            "--without-doctor",
            *flags,
        ) as (
            process,
            screen,
        ),
    ):
        read(screen, lambda text: b"to move the robot anyway: " in text)
        os.write(screen, b"map-error\n")
        said = read(screen, lambda text: b"waiting for an operator" in text)
        os.write(screen, b"arm\n")
        rest = said + read(screen, lambda text: False)
        assert process.wait(PATIENCE) == 1, rest
        end(stand_in)
    assert b"accepted: map-error: controller.collision.stopping" in rest
    metrics = json.loads((output / "metrics.json").read_text())
    assert [entry["name"] for entry in metrics["accepted"]] == ["map-error"]
    assert metrics["outcome"] == "time limit" and metrics["path_length"] > 0
