"""Scan suites: targets in scanned scenes, on several maps of them."""

import dataclasses as dc
from pathlib import Path

import numpy as np
import pytest
from own_cache import use_cache

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.benchmark.methods import load_methods
from remosplat_drake.benchmark.result import SUCCESS
from remosplat_drake.benchmark.scan_suite import SCANS_DIR, scan_cases
from remosplat_drake.benchmark.suites import load_cases
from remosplat_drake.benchmark.trial import Trial, run_trial
from remosplat_drake.capture.readers.nerfstudio import write_capture
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.splat.codecs.ply import write_ply

SUITE = """
board:
  data: data
  truth: {truth}
  start: [-0.4, 0.0, 0.0]
  targets:
    over-the-board: {{translation: [0.9, -0.2, 0.7], rpy_deg: [180, 0, 0]}}
    beside-it: {{translation: [0.3, 0.3, 0.8], rpy_deg: [180, 0, 0]}}
  maps:
    clean: {{splat: board.ply}}
    floaters: {{splat: board.ply, floaters: 20, seed: 3}}
    shifted: {{splat: board.ply, X_WG: {{translation: [0, 0, 1]}}, noisy: true}}
"""


@pytest.fixture
def write_suite(tmp_path, monkeypatch, scene, scene_capture):
    """Writes a suite with solids or a capture as its truth."""
    use_cache(monkeypatch, tmp_path / "cache")
    data = tmp_path / "data"
    data.mkdir()
    write_ply(data / "board.ply", surfel_splat(scene, 2000))
    write_rmmi(data / "scene.json", scene)

    def write(truth: str = "!SolidsTruth {file: scene.json}") -> str:
        if "Capture" in truth:
            write_capture(data / "capture", scene_capture)
        (tmp_path / "suite.yaml").write_text(SUITE.format(truth=truth))
        return str(tmp_path / "suite.yaml")

    return write


def test_every_target_is_a_case_on_every_map(write_suite):
    cases = load_cases(f"scan:{write_suite()}", 20)
    assert [(c.suite, c.family, c.name) for c in cases[1:5]] == [
        ("board, clean map", "scan", "board/clean/beside-it"),
        ("board, floaters map", "noisy scan", "board/floaters/over-the-board"),
        ("board, floaters map", "noisy scan", "board/floaters/beside-it"),
        ("board, shifted map", "noisy scan", "board/shifted/over-the-board"),
    ]
    task = cases[0].task()
    assert task.X_WB_start == (-0.4, 0.0, 0.0)
    np.testing.assert_allclose(task.X_WE_target.translation(), [0.9, -0.2, 0.7])
    # The cylinder's side is nearer than the board, 27 cm below.
    point = Spheres.at(np.array([0.9, -0.2, 0.7]))
    distance = task.truth_field.clearances(point).minimum()
    assert distance == pytest.approx(np.hypot(0.1, 0.3) - 0.05)


def test_maps_are_placed_and_given_floaters(write_suite):
    clean, floaters, shifted = (
        case.splat() for case in scan_cases(write_suite())[::2]
    )
    assert (clean[1], floaters[1]) == ("trained", "trained with 20 floaters")
    assert len(floaters[0]) == len(clean[0]) + 20
    np.testing.assert_allclose(
        shifted[0].p_GK, clean[0].p_GK + np.eye(3)[2], atol=1e-6
    )


def test_keys_tell_maps_targets_and_content_apart(write_suite):
    file = write_suite()
    cases = scan_cases(file)
    for name in ("sdf-hard", "ellipsoid-active"):
        (method,) = load_methods([name])
        keys = [Trial(method, case).key() for case in cases]
        assert len(set(keys)) == len(cases) == 6
    # The same data elsewhere is the same trial.
    moved = Path(file).parent / "elsewhere"
    (Path(file).parent / "data").rename(moved)
    again = scan_cases(f"{file}:{moved}")
    assert [Trial(method, case).key() for case in again] == keys


def test_a_capture_is_a_truth(write_suite, scene):
    file = write_suite("!CaptureTruth {folder: capture}")
    case = scan_cases(file)[0]
    task = case.task()
    assert task.solids is None
    # Before the board's middle, seen by many views.
    point = Spheres.at(np.array([1.1, -0.2, 0.6]))
    distance = task.truth_field.clearances(point).minimum()
    assert distance == pytest.approx(0.17, abs=0.005)
    # What needs no splat takes the measured surfaces for its map.
    for name in ("sdf-active", "ellipsoid-active"):
        (method,) = load_methods([name], "{time_limit: 0.2}")
        result = run_trial(Trial(method, dc.replace(case, target="beside-it")))
        assert result.text is not None
        assert 0 < result.text.minimum_distance < 1


def test_a_target_in_the_open_is_reached(write_suite):
    (method,) = load_methods(["ellipsoid-active"])
    case = dc.replace(scan_cases(write_suite())[0], target="beside-it")
    result = run_trial(Trial(method, case))
    assert result.outcome("text") == SUCCESS
    assert (result.suite, result.splat) == ("board, clean map", "trained")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("board.ply", "other.ply", r"board: maps.clean.splat: other.ply: no"),
        ("start: [-0.4, 0.0, 0.0]", "start: [1]", "start: expected 3 entries"),
        ("floaters: 20", "floaters: -1", "maps.floaters.floaters"),
        ("rpy_deg: [180, 0, 0]", "rpy_deg: [1]", "targets.over-the-board"),
        ("scene.json", "none.json", "truth.file: none.json: no such file"),
        ("!SolidsTruth", "!Magic", "unknown tag 'Magic'"),
    ],
)
def test_what_cannot_be_used_is_named(write_suite, old, new, message):
    path = Path(write_suite())
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(RemoSplatError, match=message):
        scan_cases(str(path))


def test_unknown_suites_are_named():
    with pytest.raises(RemoSplatError, match="valid: demo, redkitchen"):
        scan_cases("kitchen")
    with pytest.raises(RemoSplatError, match="scan:NAME:FOLDER"):
        scan_cases("redkitchen:/nowhere")


def test_the_shipped_suites_can_be_used():
    assert {path.stem for path in SCANS_DIR.iterdir()} == {
        "demo",
        "redkitchen",
    }
    demo = scan_cases("demo")
    assert {case.suite for case in demo if case.scene == "table"} == {
        "table, clean map",
        "table, floaters map",
    }
