"""`remosplat teleop` without a browser: sessions, and a user's mistakes."""

import json
import re
import shutil
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import yaml
from runs import remosplat

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.scenario_text import scenario_text
from remosplat_drake.commands.main import USER_ERROR, main
from remosplat_drake.mapping.store.map_file import KIND, open_map, write_map
from remosplat_drake.mapping.store.session import (
    SCENARIO_FILE,
    SESSION_FILE,
    Session,
    Version,
)
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.recording.events import MAP, TARGET, Event, read_events
from remosplat_drake.recording.run_log import RunLog, read_log
from remosplat_drake.recording.trajectory_log import EVENTS, LOG
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.splat.gaussian_splat import GaussianSplat

COARSE = (
    "{mapping: {frames: 3, latency: 0.5, voxel: 0.1, discs: 3000},"
    " teleop: {scan: {pan_deg: 20, steep_deg: 50}},"
    " wrist_camera: {width: 96, height: 72}}"
)
"""Small pictures and maps, at times that depend on no computer."""

THERE = [0.75, 0.0, 0.75]
STEPS = [
    {"time": 0.1, "press": "scan"},
    {"time": 6.0, "translation": THERE, "rpy_deg": [180, 0, 0]},
    {"time": 8.0, "press": "frame"},
    {"time": 9.0, "press": "undo"},
]


@pytest.fixture
def session(tmp_path):
    return tmp_path / "session"


def written(folder: Path, *steps: dict) -> Path:
    """An operator's script."""
    path = folder / "script.yaml"
    path.write_text(yaml.safe_dump({"steps": list(steps)}))
    return path


@pytest.fixture
def script(tmp_path):
    """Writes an operator's script."""
    return partial(written, tmp_path)


def operate(session, script, duration: float, *arguments: str) -> str:
    """What a session without a page tells on its way."""
    done = remosplat(
        *("teleop", *arguments, "--headless", "--realtime-rate", "50"),
        *("--session", session, "--trajectory", script),
        *("--duration", str(duration)),
    )
    assert done.returncode == 0, done.stderr
    return done.stderr


def recorded(session, number: int) -> tuple[RunLog, list[Event]]:
    run = session / "runs" / f"{number:04d}"
    return read_log(run / LOG), read_events(run / EVENTS)


@pytest.fixture(scope="module")
def scripted(tmp_path_factory):
    """A session of all `STEPS`, and what it told on its way."""
    folder = tmp_path_factory.mktemp("scripted")
    arguments = "StudioLive", "--scenario-text", COARSE
    session, script = folder / "session", written(folder, *STEPS)
    return session, operate(session, script, 10.0, *arguments)


@pytest.mark.smoke
def test_a_script_scans_drives_and_goes_back_a_map(
    scripted, session, script, frankie
):
    first, said = scripted
    # Where lines are broken depends on how long the folder's name is.
    shown = "".join(said.split())
    assert f"`remosplatreplay{first}`showsit" in shown
    assert said.count("map: frame 1 added\n") == 1
    assert re.findall(r"^map: version (\d): ", said, re.MULTILINE) == [*"121"]
    log, events = recorded(first, 1)
    assert [e.version for e in events if e.kind == MAP] == [0, 1, 2, 1]
    assert "scan done" in [e.text for e in events if e.kind == TARGET]
    # Three frames and half a second later the first map counts.
    versions = log.rows["map_version"]
    assert len(log) == 1000 and sorted(set(versions)) == [0, 1, 2]
    p_WE = frankie.end_effector_pose(log.rows["q"][-1])[:3, 3]
    assert np.linalg.norm(p_WE - THERE) < 0.05
    assert log.rows["clearance"].min() > 0

    shutil.copytree(first, session)
    operate(session, script({"time": 0, "press": "hold"}), 0.2)
    again, _ = recorded(session, 2)
    assert set(again.rows["map_version"]) == {1}
    made = Session.open(session)
    assert not load_scenario(str(session / SCENARIO_FILE)).teleop.trajectory
    assert made.head_map is not None
    assert len(open_map(made.head_map).frames) == 3
    assert main(["replay", str(session), "--run", "1", "--no-hold"]) == 0


def test_without_a_page_a_stop_is_the_end(session, script, capsys):
    """No operator could release it. The simulated arm is in another mode."""
    path = script({"time": 0, "press": "hold"})
    text = "supervisor: {robot_modes: [guiding]}"
    arguments = "--session", session, "--trajectory", path, "--headless"
    arguments = *arguments, "--duration", "60"
    command = "teleop", "StudioLive", "--scenario-text", text, *arguments
    assert main([str(part) for part in command]) == 1
    assert "stopped: " in capsys.readouterr().err


def studio() -> str:
    """The scenario's file in a session's folder."""
    return scenario_text(load_scenario("StudioLive"), "StudioLive")


def refuse(capsys, *arguments) -> str:
    """The line that says why a command line is not carried out."""
    assert main(["teleop", *map(str, arguments)]) == USER_ERROR
    said = capsys.readouterr().err
    lines = [line for line in said.splitlines() if "compil" not in line]
    assert len(lines) == 1, said
    return lines[0]


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["StudioLove"], "unknown scenario 'StudioLove' (did you mean"),
        (["StudioLive", "--headless"], "--headless: without a page"),
        (["StudioLive", "--lcm-url", "x"], "only with --hardware"),
        (
            ["TableTeleop", "--scenario-text", "mapping: {unknown: obstacle}"],
            "unknown field 'unknown'",
        ),
        (["StudioLive", "--port", "80"], "--port: 80 is not 1024 to 65535"),
        (
            ["Ur5eReach"],
            "wrist_camera.frame: unknown frame 'wrist_camera'",
        ),
    ],
)
def test_an_impossible_wish_is_one_line(session, capsys, arguments, problem):
    assert problem in refuse(capsys, *arguments, "--session", session)
    assert not session.exists()


@pytest.mark.parametrize(
    ("step", "problem"),
    [
        ({"time": 0, "press": "scann"}, "steps[0].press: unknown button"),
        ({"tyme": 0, "press": "hold"}, "tyme"),
    ],
)
def test_a_bad_script_begins_no_session(
    tmp_path, script, capsys, monkeypatch, step, problem
):
    monkeypatch.chdir(tmp_path)
    path = script(step)
    line = refuse(capsys, "--headless", "--trajectory", path)
    assert str(path) in line and problem in line
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.slow
def test_a_script_moves_one_hand_after_the_other(session, script):
    path = script(
        {"time": 0.0, "translation": [0.5, 0.25, 0.4]},
        {"time": 3.0, "effector": "right", "translation": [0.5, -0.25, 0.4]},
    )
    text = "mapping: {enabled: false}"
    arguments = "TwoPandasReach", "--scenario-text", text
    operate(session, path, 6.0, *arguments)
    log, _ = recorded(session, 1)
    robot = load_robot("two_pandas")
    left, right = robot.end_effector_poses(log.rows["q"][-1])[:, :3, 3]
    np.testing.assert_allclose(left, [0.5, 0.25, 0.4], atol=0.02)
    np.testing.assert_allclose(right, [0.5, -0.25, 0.4], atol=0.02)
    assert log.rows["clearance"].min() > 0


def test_an_unknown_hand_of_a_script_is_one_line(session, script, capsys):
    path = script({"time": 0, "effector": "middle", "press": "hold"})
    text = "mapping: {enabled: false}"
    arguments = "TwoPandasReach", "--scenario-text", text, "--headless"
    line = refuse(
        capsys, *arguments, "--trajectory", path, "--session", session
    )
    assert "steps[0].effector: unknown end effector 'middle'" in line
    assert "valid: left, right" in line


def test_a_bad_script_begins_no_run(session, script, capsys):
    Session.create(session, studio())
    before = sorted(session.rglob("*"))
    path = script({"time": 0, "press": "scann"})
    arguments = "--headless", "--trajectory", path, "--session", session
    assert "unknown button" in refuse(capsys, *arguments)
    assert sorted(session.rglob("*")) == before


def test_what_a_live_map_needs_is_named(session, capsys, monkeypatch):
    # So Python takes note of a package that is not there.
    monkeypatch.setitem(sys.modules, "open3d", None)
    line = refuse(capsys, "StudioLive", "--session", session)
    assert "pip install 'remosplat-drake[reconstruction]'" in line
    assert not session.exists()


def test_a_session_has_its_own_scenario(session, capsys):
    Session.create(session, studio())
    line = refuse(capsys, "StudioLive", "--session", session)
    assert "is an existing session with its own scenario" in line


def test_a_folder_with_something_else_is_left_alone(session, capsys):
    session.mkdir()
    (session / "thesis.tex").touch()
    line = refuse(capsys, "StudioLive", "--session", session)
    assert "choose a new folder" in line
    assert [path.name for path in session.iterdir()] == ["thesis.tex"]


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda document: "{", "session.json: "),
        (lambda document: "[]", "session.json: "),
        (lambda document: document | {"format": "cake"}, "is not a 'remosplat"),
        (lambda document: document | {"head": 3}, "head: there is no map 3"),
        (
            lambda document: document | {"versions": [{}]},
            "versions[0].version: is missing",
        ),
        (
            lambda document: document | {"active": None},
            "active: expected a list, got None",
        ),
    ],
)
def test_a_damaged_session_is_left_as_it_is(session, capsys, change, problem):
    Session.create(session, studio())
    path = session / SESSION_FILE
    changed = change(json.loads(path.read_text()))
    if not isinstance(changed, str):
        changed = json.dumps(changed)
    path.write_text(changed)
    before = sorted(session.rglob("*"))
    line = refuse(capsys, "--session", session)
    assert str(path) in line and problem in line
    assert path.read_text() == changed
    assert sorted(session.rglob("*")) == before


def test_a_session_without_its_map_is_left_as_it_is(session, capsys):
    made = Session.create(session, studio())
    made.record(Version(1, 0, "maps/map_0001.rsmap", (), 1.0), set())
    before = sorted(session.rglob("*"))
    assert "map_0001.rsmap: " in refuse(capsys, "--session", session)
    assert sorted(session.rglob("*")) == before


def test_a_damaged_map_is_not_driven_by(session, capsys):
    """Nor is any other thing in its place looked into."""
    made = Session.create(session, studio())
    made.record(Version(1, 0, "maps/map_0001.rsmap", (), 1.0), set())
    path = made.map_path(1)
    write_map(path, half_a_map())
    data = bytearray(path.read_bytes())
    data[data.index(half_a_map().splat_W.scales.tobytes())] ^= 1
    path.write_bytes(data)
    before = sorted(session.rglob("*"))
    line = refuse(capsys, "--session", session)
    assert f"{path}: is damaged: the checksum of 'splat.scales'" in line
    assert sorted(session.rglob("*")) == before


def half_a_map() -> SceneMap:
    splat_W = GaussianSplat(
        p_GK=np.ones((1, 3)),
        quaternions=np.array([[1.0, 0, 0, 0]]),
        scales=np.full((1, 2), 0.0123),
        opacities=np.ones(1),
        colors=np.ones((1, 3)),
    )
    field = SphereToEllipsoidField(splat_W)
    return SceneMap(1, 0, (), 0.0, field, splat_W)


def test_a_map_of_format_1_is_made_anew_of_its_frames(
    scripted, session, script
):
    """The robot waits for it behind what it knew at the start."""
    shutil.copytree(scripted[0], session)
    made = Session.open(session)
    path = made.map_path(1)
    data = bytearray(path.read_bytes())
    data[len(KIND.magic)] = 1
    path.write_bytes(data)
    said = operate(session, script({"time": 0.1, "press": "hold"}), 1.0)
    assert "is a map of format 1; this program reads 4" in said
    again = Session.open(session)
    assert again.head == 3 and again.map_frames == made.map_frames
    assert again.head_map is not None
    assert open_map(again.head_map).parent == 1
    log, events = recorded(session, 2)
    assert [e.version for e in events if e.kind == MAP] == [0, 3]
    assert log.rows["map_version"][-1] == 3
