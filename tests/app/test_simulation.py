"""Whole runs in a nearly empty world: how they end and what they leave."""

import dataclasses as dc
import gc
import json
import re
import resource
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator, SimulatorConfig

from remosplat_drake.app.diagram import Application, build
from remosplat_drake.app.run_files import (
    METRICS,
    TRAJECTORY,
    run_document,
    save_result,
)
from remosplat_drake.app.run_monitor import RunMonitor
from remosplat_drake.app.run_result import (
    INTERRUPTED,
    REACHED,
    TIME_LIMIT,
    RunResult,
)
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run, simulator_config
from remosplat_drake.app.world import load_world
from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.commands import driving
from remosplat_drake.commands import run as run_command
from remosplat_drake.commands.main import main
from remosplat_drake.recording.trajectory import load_trajectory
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.signals.tick_report import TickReport

HOME = """
  scene: {truth: scene.json}
  oracle: !GroundTruth {}
  control_period: 0.02
  time_limit: 8
"""


@pytest.fixture
def folder(tmp_path, frankie) -> Path:
    """One box behind the robot; targets before its end effector."""
    box = Box(RigidTransform([-0.8, 0, 0.5]), np.array([0.1, 0.5, 0.5]))
    write_rmmi(tmp_path / "scene.json", PrimitiveScene(boxes=(box,)))
    X_WE = frankie.end_effector_pose(np.array([0, 0, 0, *frankie.home]))

    def target(x: float, y: float) -> str:
        p_WT = X_WE[:3, 3] + np.array([x, y, 0])
        return (
            f"  - translation: {p_WT.tolist()}\n"
            f"    rotation: {X_WE[:3, :3].tolist()}\n"
        )

    (tmp_path / "test.yaml").write_text(
        f"One:{HOME}  targets:\n{target(0.1, 0.05)}"
        f"Two:{HOME}  targets:\n{target(0.1, 0.05)}{target(0.1, -0.1)}"
        f"Here:{HOME}  targets:\n{target(0, 0)}"
        f"Far:{HOME}  targets:\n{target(9, 0)}"
    )
    return tmp_path


def make_application(folder: Path, name: str, text: str = "") -> Application:
    scenario = load_scenario(f"{folder}/test.yaml:{name}", text)
    return build(scenario, load_world(scenario))


def check_consistent(result: RunResult, application: Application) -> None:
    """What holds for every run, however it ended."""
    trajectory = result.trajectory
    dt = application.scenario.control_period
    n = len(trajectory)
    assert trajectory.q.shape == (n + 1, 10)
    assert trajectory.u.shape == (n, 9)
    assert result.metrics.ticks == n
    assert result.metrics.duration == pytest.approx(n * dt)
    np.testing.assert_allclose(trajectory.time, dt * np.arange(n), atol=1e-9)
    assert sum(result.metrics.statuses.values()) == n


def test_a_target_is_reached(folder):
    application = make_application(folder, "One")
    result = run(application)
    assert result.outcome == REACHED
    assert (result.targets_reached, result.targets) == (1, 1)
    assert result.position_error < 0.02
    assert result.angle_error < np.radians(2)
    assert result.metrics.duration < 5
    assert result.metrics.truth_clearance_min > 0.1
    # Not much longer than the straight way.
    straight = np.hypot(0.1, 0.05)
    assert straight - 0.02 < result.metrics.path_length < 1.5 * straight
    check_consistent(result, application)


def test_targets_are_reached_one_after_the_other(folder):
    application = make_application(folder, "Two")
    result = run(application)
    assert result.outcome == REACHED
    assert (result.targets_reached, result.targets) == (2, 2)
    # The run ends at the second one.
    robot = application.world.robot
    p_WE = robot.end_effector_pose(result.trajectory.q[-1])[:3, 3]
    p_WT = application.scenario.targets[1].translation
    assert np.linalg.norm(p_WE - p_WT) < 0.03
    check_consistent(result, application)


def test_who_is_there_already_has_arrived(folder):
    result = run(make_application(folder, "Here"))
    assert result.outcome == REACHED
    assert len(result.trajectory) <= 2


def test_progress_is_told_no_more_often_than_wanted(folder):
    application = make_application(folder, "Far")
    told = []
    monitor = RunMonitor(
        application,
        on_progress=lambda t, *_: told.append(t),
        progress_period=0.05,
    )
    context = Simulator(application.diagram).get_mutable_context()
    for t in (0.0, 0.02, 0.04, 0.06, 0.1, 0.12, 0.02):  # A clock set back.
        context.SetTime(t)
        monitor(context)
    assert told == [0.0, 0.06, 0.12, 0.02]


def test_time_runs_out(folder):
    application = make_application(folder, "Far", "{time_limit: 0.3}")
    result = run(application)
    assert result.outcome == TIME_LIMIT
    assert result.targets_reached == 0
    assert result.position_error > 8
    assert len(result.trajectory) == 15
    check_consistent(result, application)


def test_an_interrupted_run_keeps_what_it_has(folder):
    application = make_application(folder, "One")

    def interrupt(t, error, report):
        if t > 0.1:
            raise KeyboardInterrupt

    result = run(application, on_progress=interrupt)
    assert result.outcome == INTERRUPTED
    assert len(result.trajectory) == 6
    check_consistent(result, application)


@pytest.fixture
def heard_ctrl_c() -> Iterator[None]:
    """Ctrl-C as on a terminal: processes in the background ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heard_ctrl_c")
def test_ctrl_c_ends_the_run_after_its_step(folder, monkeypatch):
    """In the middle of a step, it would come out of a kernel as a defect."""
    application = make_application(folder, "One")
    spheres_at = RobotModel.spheres_at
    calls = []

    def interrupted(robot, q):
        if application.recorder.latest is not None and not calls:
            signal.raise_signal(signal.SIGINT)
            calls.append("passed")
        return spheres_at(robot, q)

    monkeypatch.setattr(RobotModel, "spheres_at", interrupted)
    before = signal.getsignal(signal.SIGINT)
    result = run(application)
    assert signal.getsignal(signal.SIGINT) is before
    assert calls == ["passed"]
    assert result.outcome == INTERRUPTED
    with pytest.raises(KeyboardInterrupt):
        result.uninterrupted()
    assert 1 <= len(result.trajectory) <= 3
    check_consistent(result, application)


def test_a_run_does_not_keep_its_reports(folder):
    """After three times as long there are as many in memory."""
    alive = []

    def count(t, motion_status, report):
        if round(t / 0.02) in (40, 120):
            gc.collect()
            found = [isinstance(o, TickReport) for o in gc.get_objects()]
            alive.append(sum(found))

    application = make_application(folder, "Far", "{time_limit: 2.5}")
    result = run(application, on_progress=count)
    assert len(result.trajectory) == 125
    assert alive[0] == alive[1]


def save(result, application, folder):
    save_result(result, run_document(result, application, None, {}), folder)


def test_the_files_of_a_folder_are_of_one_run(folder):
    """The metrics of the second run do not fit on the disk."""
    application = make_application(folder, "Here")
    first = run(application)
    save(first, application, folder)
    files = [folder / name for name in (METRICS, TRAJECTORY)]
    before = [file.read_bytes() for file in files]
    application = make_application(folder, "One")
    second = run(application)
    talkative = dc.replace(second, motion_history=2000 * second.motion_history)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, hard))
    try:
        with pytest.raises(FileError, match=r"metrics\.json: .*too large"):
            save(talkative, application, folder)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert [file.read_bytes() for file in files] == before
    save(second, application, folder)
    for file, old in zip(files, before, strict=True):
        assert file.read_bytes() != old


def test_a_stop_ends_the_run_and_is_no_arrival(folder):
    """The second target is a jump that this supervisor does not allow."""
    application = make_application(
        folder, "Two", "{supervisor: {max_target_jump: 0.1}}"
    )
    modes = []
    result = run(
        application, on_supervision=lambda state: modes.append(state.mode)
    )
    assert modes == ["starting", "running", "stopping", "stopped"]
    assert result.outcome == "stopped: the target jumped by 0.15 m"
    assert result.targets_reached == 1
    assert not result.trajectory.u[-1].any()
    check_consistent(result, application)
    # It came to rest within the robot's limits.
    change = np.abs(np.diff(result.trajectory.u, axis=0)) / 0.02
    limit = application.world.robot.acceleration_limit
    assert (change <= limit * (1 + 1e-9)).all()


def test_a_stopped_robot_waits_for_its_release(folder):
    """The time limit does not count the wait."""
    application = make_application(
        folder,
        "Two",
        "{supervisor: {max_target_jump: 0.1}, time_limit: 5}",
    )
    result = run(application, patience=2.0)
    assert result.outcome.startswith("stopped")
    standing = (result.trajectory.u == 0).all(axis=1)
    assert standing[-100:].all() and not standing[-110:].all()


def test_progress_is_told_at_every_tick(folder):
    seen = []
    application = make_application(folder, "One", "{time_limit: 0.2}")
    run(
        application,
        on_progress=lambda t, motion_status, report: seen.append(
            (t, motion_status.distance, report)
        ),
    )
    t, distance, reports = zip(*seen, strict=True)
    np.testing.assert_allclose(np.unique(t), 0.02 * np.arange(11), atol=1e-9)
    assert np.isnan(distance[0])
    assert distance[-1] < distance[2]
    assert reports[0] is None
    assert reports[-1].time == pytest.approx(0.18)


def test_equal_runs_are_equal(folder):
    first, second = (run(make_application(folder, "Two")) for _ in range(2))
    np.testing.assert_array_equal(first.trajectory.q, second.trajectory.q)
    np.testing.assert_array_equal(first.trajectory.u, second.trajectory.u)


def test_an_application_can_be_run_again(folder):
    application = make_application(folder, "One")
    first, second = run(application), run(application)
    np.testing.assert_array_equal(first.trajectory.q, second.trajectory.q)


# The command


def remosplat_run(folder: Path, name: str, *flags: str) -> int:
    return main(["run", f"{folder}/test.yaml:{name}", "--headless", *flags])


def test_reaching_exits_with_0_and_leaves_its_record(folder, capfd):
    output = folder / "new" / "output"
    assert remosplat_run(folder, "One", "--output", str(output)) == 0
    assert "reached" in capfd.readouterr().out
    metrics = json.loads((output / "metrics.json").read_text())
    assert metrics["outcome"] == REACHED
    assert metrics["motion_status"]["kind"] == "reached"
    assert metrics["motion_history"][0]["kind"] == "moving"
    assert metrics["motion_history"][0]["text"].startswith(
        "moving to the target"
    )
    assert metrics["scenario"] == f"{folder}/test.yaml:One"
    assert metrics["truth_clearance_min"] > 0
    trajectory = load_trajectory(output / "trajectory.npz")
    assert len(trajectory) == metrics["ticks"]
    assert sorted(p.name for p in output.iterdir()) == [
        "metrics.json",
        "trajectory.npz",
    ]


def test_not_reaching_exits_with_1_and_says_how_far_it_is(folder, capfd):
    assert (
        remosplat_run(folder, "Far", "--scenario-text", "{time_limit: 0.2}")
        == 1
    )
    said = " ".join(capfd.readouterr().out.split())
    told = r"time limit: moving to the target, (8\.9|9\.0)\d m away"
    assert re.search(told, said)


def test_a_stop_exits_with_1_and_is_named(folder, capfd):
    """No simulated arm is in this mode."""
    text = "{supervisor: {robot_modes: [guiding]}}"
    output = folder / "out"
    assert (
        remosplat_run(
            folder, "Here", "--scenario-text", text, "--output", str(output)
        )
        == 1
    )
    assert "stopped: the arm's mode is move" in capfd.readouterr().err
    metrics = json.loads((output / "metrics.json").read_text())
    assert metrics["outcome"] == "stopped: the arm's mode is move"
    assert metrics["motion_status"]["text"].startswith(
        "stopped: the arm's mode is move; waiting for an operator"
    )


def test_an_interrupt_exits_with_130_and_leaves_its_record(folder, monkeypatch):
    def interrupted(application, **arguments):
        def stop(t, error, report):
            if t > 0.1:
                raise KeyboardInterrupt

        return run(application, on_progress=stop)

    monkeypatch.setattr(driving, "simulate", interrupted)
    assert remosplat_run(folder, "One", "--output", str(folder / "out")) == 130
    metrics = json.loads((folder / "out" / "metrics.json").read_text())
    assert metrics["outcome"] == INTERRUPTED


def test_an_interrupt_while_loading_is_one_line(folder, monkeypatch, capfd):
    def interrupted(scenario):
        raise KeyboardInterrupt

    monkeypatch.setattr(run_command, "load_world", interrupted)
    assert remosplat_run(folder, "One") == 130
    assert "remosplat: interrupted" in capfd.readouterr().err


def test_the_diagram_can_be_drawn(folder):
    file = folder / "diagram.dot"
    flags = ("--graphviz", str(file), "--scenario-text", "{time_limit: 0.1}")
    remosplat_run(folder, "One", *flags)
    text = file.read_text()
    assert text.startswith("digraph")
    for name in ("station", "oracle", "controller", "targets", "recorder"):
        assert name in text


def test_a_place_that_cannot_be_written_is_one_line(folder, capfd):
    (folder / "file").write_text("")
    code = remosplat_run(
        folder,
        "Far",
        "--scenario-text",
        "{time_limit: 0.1}",
        "--output",
        str(folder / "file" / "below"),
    )
    assert code == 2
    last = capfd.readouterr().err.strip().splitlines()[-1]
    assert last.startswith("remosplat: ")
    assert "file/below" in last


@pytest.mark.parametrize("flag", [["--realtime-rate", "-1"], ["--bogus"]])
def test_bad_flags_exit_with_2(folder, flag, capfd):
    assert remosplat_run(folder, "One", *flag) == 2
    assert flag[0] in capfd.readouterr().err


# Drake's `SimulatorConfig`.


def test_a_scenario_takes_the_settings_of_drakes_simulator(folder):
    text = (
        "{time_limit: 0.1, simulator: {integration_scheme: runge_kutta2,"
        " max_step_size: 0.005, use_error_control: false}}"
    )
    exact = run(make_application(folder, "Far", "{time_limit: 0.1}"))
    application = make_application(folder, "Far", text)
    config = simulator_config(application.scenario)
    assert config.integration_scheme == "runge_kutta2"
    assert config.max_step_size == 0.005
    assert config.accuracy == SimulatorConfig().accuracy
    given = run(application)
    difference = np.abs(given.trajectory.q - exact.trajectory.q).max()
    assert 0 < difference < 1e-6


def test_a_run_keeps_the_pace_of_its_scenario_unless_told_otherwise(folder):
    """At a ten-thousandth of the clock's pace it would take half an hour."""
    text = "{time_limit: 0.2, simulator: {target_realtime_rate: %g}}"
    start = time.monotonic()
    run(make_application(folder, "Far", text % 1e-4), realtime_rate=0.0)
    unlimited = time.monotonic()
    run(make_application(folder, "Far", text % 0.5))
    assert unlimited - start < 1000
    # Drake keeps to the pace up to the start of the last step.
    assert time.monotonic() - unlimited > 0.3


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("accuracy: .nan", "simulator.accuracy: must be finite, got '.nan'"),
        ("accuracy: 0", "simulator.accuracy: must be positive, got 0.0"),
        ("max_step_size: 0", "simulator.max_step_size: must be positive"),
        ("max_step_size: fast", "simulator.max_step_size: expected a number"),
        ("max_step: 1", "simulator.max_step: unknown field 'max_step'"),
        ("start_time: 1", "simulator.start_time: must be 0, got 1.0"),
        ("target_realtime_rate: -1", "must not be negative, got -1.0"),
        ("integration_scheme: euler", "unknown integration scheme 'euler'"),
    ],
)
def test_settings_that_no_simulation_can_run_with_are_refused(text, problem):
    with pytest.raises(FieldError) as caught:
        load_scenario("TableReach", f"{{simulator: {{{text}}}}}")
    assert str(caught.value).startswith("--scenario-text:1: simulator.")
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)
