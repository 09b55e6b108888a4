"""`remosplat run` as a process: interrupts, taken ports, unusable files."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE
from runs import (
    SAY_STARTED,
    assert_one_line,
    command_line,
    complaint,
    remosplat,
)

from remosplat_drake.app.scenario import DEFAULT_SCENARIO, load_scenario
from remosplat_drake.splat.codecs.ply import write_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat

# Ctrl-C


def start(*arguments: str | Path, **environment: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        command_line(*arguments),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | environment,
    )


def interrupt(process: subprocess.Popen[str]) -> str:
    """Sends Ctrl-C once; returns what the process printed until it ended."""
    process.send_signal(signal.SIGINT)
    result, error = process.communicate(timeout=PATIENCE)
    assert "Traceback" not in error, error
    assert process.returncode == 130, error
    return result + error


def wait_for_drawing(process: subprocess.Popen[str], drawing: Path):
    """Waits for what `--graphviz` writes right before the run starts."""
    deadline = time.monotonic() + PATIENCE
    while not drawing.exists():
        assert time.monotonic() < deadline and process.poll() is None
        time.sleep(0.05)


def test_an_interrupted_run_sums_up_what_it_did(tmp_path):
    process = start(
        "run",
        "--headless",
        "--realtime-rate",
        "0.05",
        "--output",
        tmp_path / "out",
        FORCE_COLOR="1",  # Without a terminal there is no line of progress.
    )
    assert process.stderr is not None
    while "to the target" not in process.stderr.readline(60):
        assert process.poll() is None
    said = " ".join(re.sub(r"\x1b\[[\d;?]*\w", "", interrupt(process)).split())
    assert "outcome interrupted: moving to the target" in said
    assert "clearance (truth) min" in said
    metrics = json.loads((tmp_path / "out" / "metrics.json").read_text())
    assert metrics["outcome"] == "interrupted"
    assert 0 < metrics["ticks"] < 100


def children(pid: int) -> set[int]:
    """The processes that any thread of a process has started."""
    lists = Path(f"/proc/{pid}/task").glob("*/children")
    return {int(child) for path in lists for child in path.read_text().split()}


def shared_memory(processes: set[int]) -> set[Path]:
    """The shared memory that processes have mapped."""
    maps = [Path(f"/proc/{pid}/maps").read_text() for pid in processes]
    return {
        Path(line[line.index("/dev/shm/") :])
        for line in "".join(maps).splitlines()
        if "/dev/shm/" in line
    }


@pytest.mark.parametrize(
    "end",
    [
        pytest.param(None, marks=pytest.mark.slow),
        pytest.param(signal.SIGINT, marks=pytest.mark.slow),
        pytest.param(signal.SIGTERM, marks=pytest.mark.slow),
        signal.SIGKILL,
    ],
)
def test_looking_ahead_in_another_process_leaves_nothing_behind(tmp_path, end):
    drawing = tmp_path / "diagram.dot"
    process = start(
        "run",
        "--headless",
        "--realtime-rate",
        "0.1",
        "--graphviz",
        drawing,
        "--scenario-text",
        "{time_limit: 0.2, controller: {guidance: {asynchronous: true}}}",
    )
    wait_for_drawing(process, drawing)
    started = children(process.pid)
    assert started  # The look-ahead process, for one.
    shared = shared_memory({process.pid, *started})
    if end is not None:
        process.send_signal(end)
    process.communicate(timeout=PATIENCE)
    deadline = time.monotonic() + PATIENCE
    while any(Path(f"/proc/{child}").exists() for child in started):
        assert time.monotonic() < deadline, "a process lives on"
        time.sleep(0.05)
    assert not [path for path in shared if path.exists()]


@pytest.mark.parametrize("seconds", [0.2, 0.6])
def test_an_interrupt_while_starting_is_one_line(seconds):
    process = start(
        "run", "--headless", "--realtime-rate", "0.05", **{SAY_STARTED: "1"}
    )
    assert process.stdout is not None
    assert process.stdout.readline().strip() == SAY_STARTED
    time.sleep(seconds)
    error = interrupt(process)
    assert error.splitlines()[-1] == "remosplat: interrupted"


# What can be known before the run is said before the run


def test_a_taken_port_is_one_line():
    with socket.create_server(("localhost", 0)) as server:
        port = server.getsockname()[1]
        result = remosplat("run", "--port", str(port))
    assert_one_line(result, str(port), "taken")


@pytest.mark.parametrize("flag", ["--output", "--save-html", "--graphviz"])
def test_an_output_that_cannot_be_written_stops_the_start(
    tmp_path, capsys, flag
):
    (tmp_path / "file").touch()
    line = complaint(
        capsys,
        *("run", "--headless", "--output", tmp_path / "out"),
        *(flag, tmp_path / "file" / "below"),
    )
    assert "file/below" in line and "is not a folder" in line
    assert os.listdir(tmp_path) == ["file"]


def test_a_folder_cannot_be_a_page(tmp_path, capsys):
    line = complaint(capsys, "run", "--headless", "--save-html", tmp_path)
    assert str(tmp_path) in line and "is a folder" in line


# Splats that are no splats


def shipped_splat() -> bytes:
    scenario = load_scenario(DEFAULT_SCENARIO)
    uri = scenario.scene.splat.removeprefix("package://remosplat_drake/")
    return (Path(__file__).parents[1] / uri).read_bytes()


BROKEN = {
    "empty": b"",
    "text": b"this is a note about splats\n",
    "header only": shipped_splat()[:60],
    "truncated": shipped_splat()[:100_000],
    "followed by more": shipped_splat() + b"\x00\x01\x02",
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_splat_is_one_line(tmp_path, capsys, case):
    file = tmp_path / "broken.ply"
    file.write_bytes(BROKEN[case])
    text = f"{{scene: {{splat: {file}}}}}"
    line = complaint(capsys, "run", "--headless", "--scenario-text", text)
    assert "broken.ply" in line


# Size

MEASURED = """
import json, resource, sys, time
start = time.perf_counter()
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.app.diagram import build
from remosplat_drake.app.simulation import run
scenario = load_scenario(sys.argv[1])
load_start = time.perf_counter()
world = load_world(scenario)
loaded = time.perf_counter()
result = run(build(scenario, world))
memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps({
    "splats": len(world.splat_W), "load_s": loaded - load_start,
    "ticks": result.metrics.ticks, "tick_p50_s": result.metrics.tick_p50,
    "memory_MB": memory / 1024,
}))
"""


@pytest.mark.slow
def test_three_million_splats_load_and_run(tmp_path):
    """A cloud of surfels on the walls of a room around the robot."""
    rng = np.random.default_rng(0)
    n = 3_000_000
    p_GK = rng.uniform((-3, -3, 0), (3, 3, 2.5), (n, 3))
    wall = rng.integers(4, size=n)
    side = np.where(wall % 2, -3.0, 3.0)
    p_GK[np.arange(n), wall // 2] = side + rng.normal(0, 0.01, n)
    splat = GaussianSplat(
        p_GK=p_GK,
        quaternions=rng.normal(size=(n, 4)),
        scales=rng.uniform(0.002, 0.01, (n, 2)),
        opacities=rng.uniform(0.2, 0.99, n),
        colors=rng.uniform(0, 1, (n, 3)),
    )
    write_ply(tmp_path / "room.ply", splat, with_normals=False)
    scenario = tmp_path / "room.yaml"
    scenario.write_text(
        "Room: {scene: {splat: room.ply}, time_limit: 0.5,"
        " targets: [{translation: [2, 0, 0.7], rpy_deg: [180, 0, 0]}]}\n"
    )
    result = subprocess.run(
        [sys.executable, "-c", MEASURED, scenario],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=True,
    )
    print(result.stdout)  # Shown by pytest -s.
    measured = json.loads(result.stdout)
    assert measured["splats"] == n
    assert measured["ticks"] == 50
