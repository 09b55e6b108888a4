"""Knowledge about a scenario's map, and gates that it does not pass."""

import dataclasses as dc
from pathlib import Path

import numpy as np
import pytest
from effort import effort
from pydrake.math import RigidTransform

from remosplat_drake.app.map_knowledge import (
    MOST_UNSEEN,
    MapKnowledge,
    coverage_gates,
    examine_map,
    find_map_error,
    map_error_gates,
    saved_places,
    target_places,
    unseen_gates,
)
from remosplat_drake.app.scenario import (
    Scenario,
    load_scenario,
    shipped_scenarios,
)
from remosplat_drake.app.world import load_world
from remosplat_drake.oracle.map_summary import SPLATS, MapSummary, Place
from remosplat_drake.oracle.oracle_config import GroundTruth
from remosplat_drake.reconstruction.report.quality_report import (
    QualityReport,
    report_path,
    write_report,
)
from remosplat_drake.safety.gates import (
    CAPTURE_WARNINGS,
    EMPTY_MAP,
    IGNORED_SPLATS,
    MAP_ERROR,
    REFUSAL,
    SILENCE,
    UNKNOWN_MAP_ERROR,
    UNKNOWN_SEEN_SPACE,
    UNSEEN_SPACE,
    WARNING,
    Gate,
)
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi

# How wrong the map is


@pytest.fixture
def splat(tmp_path) -> Path:
    """A splat file that is off by 6 mm, as a report beside it says."""
    path = tmp_path / "splat.ply"
    path.write_bytes(b"a splat that is not read here")
    write_report(path, QualityReport(map_error=0.006))
    (tmp_path / "a.yaml").write_text("A: {scene: {splat: splat.ply}}\n")
    return path


def scenario(splat: Path, text: str = "") -> Scenario:
    return load_scenario(str(splat.with_name("a.yaml")), text)


def error_gates(splat: Path, text: str = "") -> list[Gate]:
    asked = scenario(splat, text)
    return map_error_gates(asked, find_map_error(asked))


STOPPING = "{{controller: {{collision: {{stopping: {}}}}}}}"
TIERS = "{{controller: {{guidance: {{tiers: [{}]}}}}}}"


def test_the_error_comes_from_the_report(splat):
    assert find_map_error(scenario(splat)).largest == 0.006
    assert scenario(splat).scene.map_error is None


@pytest.mark.parametrize(("told", "counts"), [(0.02, 0.02), (0.001, 0.006)])
def test_of_scenario_and_report_the_larger_one_counts(splat, told, counts):
    error = find_map_error(scenario(splat, f"{{scene: {{map_error: {told}}}}}"))
    assert (error.largest, error.trouble) == (counts, "")


def test_without_a_report_the_scenario_counts(splat):
    report_path(splat).unlink()
    assert "remosplat quality" in find_map_error(scenario(splat)).trouble
    error = find_map_error(scenario(splat, "{scene: {map_error: 0.02}}"))
    assert (error.largest, error.trouble) == (0.02, "")


@pytest.mark.parametrize(
    ("spoil", "problem"),
    [
        (lambda splat: splat.write_bytes(b"anew"), "belongs to another splat"),
        (lambda splat: report_path(splat).write_text("{"), "not JSON"),
        (lambda splat: report_path(splat).write_text("{}"), "is missing"),
        (lambda splat: report_path(splat).write_text("[" * 9999), "not JSON"),
    ],
)
def test_a_report_that_does_not_count_leaves_doubts(splat, spoil, problem):
    """The scenario's own number may be as old as the report."""
    spoil(splat)
    for text in ("", "{scene: {map_error: 0.002}}"):
        (gate,) = error_gates(splat, text)
        assert gate.name == UNKNOWN_MAP_ERROR
        assert problem in gate.problem and "splat.quality.json" in gate.problem


def test_true_geometry_needs_no_report(splat):
    asked = scenario(splat, "{oracle: !GroundTruth {}}")
    report_path(splat).unlink()
    assert map_error_gates(asked, find_map_error(asked)) == []


def test_what_is_wrong_with_the_capture_is_told(splat):
    write_report(splat, QualityReport(warnings=["poses: inverted"]))
    (gate,) = error_gates(splat)
    assert (gate.name, gate.problem) == (CAPTURE_WARNINGS, "poses: inverted")
    assert (gate.in_simulation, gate.on_hardware) == (WARNING, REFUSAL)


# One rule for every stopping distance


@pytest.mark.parametrize(
    ("text", "field"),
    [
        (STOPPING.format(0.0079), "controller.collision.stopping: 0.0079"),
        (TIERS.format(0.0079), "controller.guidance.tiers: 0.0079"),
        (TIERS.format("0.012, 0.0079"), "controller.guidance.tiers: 0.0079"),
    ],
)
def test_too_small_a_distance_is_refused(splat, text, field):
    (gate,) = error_gates(splat, text)
    assert gate.name == MAP_ERROR
    assert gate.in_simulation == gate.on_hardware == REFUSAL
    assert field in gate.problem and "at least 0.0080" in gate.problem


@pytest.mark.parametrize(
    "text", ["", STOPPING.format(0.008), TIERS.format(0.008)]
)
def test_distances_from_the_error_and_2_mm_on_are_allowed(splat, text):
    assert error_gates(splat, text) == []


def test_millimetres_are_not_lost_in_rounding(splat):
    asked = scenario(splat)
    for error in np.arange(0.006, 0.1, 0.001).round(3):
        asked.scene.map_error = float(error)
        asked.controller.collision.stopping = float(f"{error + 0.002:.3f}")
        assert map_error_gates(asked, find_map_error(asked)) == [], error


def test_tiers_that_are_not_used_do_not_count(splat):
    off = "{controller: {guidance: {tiers: [0.001], enabled: false}}}"
    assert error_gates(splat, off) == []


@pytest.mark.parametrize(
    ("text", "level"), [("", WARNING), (TIERS.format(0.01), REFUSAL)]
)
def test_distances_below_the_usual_one_need_a_known_error(splat, text, level):
    report_path(splat).unlink()
    (gate,) = error_gates(splat, text)
    assert gate.name == UNKNOWN_MAP_ERROR
    assert (gate.in_simulation, gate.on_hardware) == (level, REFUSAL)


# What the map holds


SOUND = MapSummary(
    SPLATS, 900, 100, 0, 1.5, (Place("the start", 10), Place("target 1", 20))
)


def test_a_sound_map_has_no_gate():
    assert coverage_gates(SOUND) == []


def test_each_place_must_know_something():
    places = Place("the start", 10), Place("target 1", 0)
    (gate,) = coverage_gates(dc.replace(SOUND, places=places))
    assert gate.name == EMPTY_MAP
    assert "has no data within 1.5 m of target 1" in gate.problem
    assert "the start" not in gate.problem


def test_a_map_of_nothing_is_named_once():
    nothing = dc.replace(
        SOUND,
        kept=0,
        faint=1000,
        places=(Place("the start", 0), Place("target 1", 0)),
        ignored=1.0,
        ignored_opacity=1.0,
    )
    (gate,) = coverage_gates(nothing)
    assert gate.name == EMPTY_MAP and "1,000 too faint" in gate.problem


@pytest.mark.parametrize(
    ("ignored", "opacity", "told"),
    # By number, as many floaters as the noisiest capture has, and more.
    [
        (0.32, 0.03, False),
        (0.7, 0.3, False),
        (0.8, 0.2, True),
        (0.6, 0.6, True),
    ],
)
def test_most_of_what_is_there_must_count(ignored, opacity, told):
    summary = dc.replace(SOUND, ignored=ignored, ignored_opacity=opacity)
    names = [gate.name for gate in coverage_gates(summary)]
    assert names == [IGNORED_SPLATS] * told


# Space that no camera has seen


@pytest.mark.parametrize(
    ("unknown", "unseen", "name", "in_simulation"),
    [
        ("absent", None, UNKNOWN_SEEN_SPACE, SILENCE),
        ("free", None, UNKNOWN_SEEN_SPACE, SILENCE),
        ("warn", None, UNKNOWN_SEEN_SPACE, WARNING),
        ("obstacle", None, UNKNOWN_SEEN_SPACE, REFUSAL),
        ("absent", 0.01, UNSEEN_SPACE, SILENCE),
        ("absent", 0.1, UNSEEN_SPACE, WARNING),
        ("warn", 0.1, UNSEEN_SPACE, WARNING),
        ("free", 0.1, UNSEEN_SPACE, SILENCE),
    ],
)
def test_unseen_space_is_told_of(unknown, unseen, name, in_simulation):
    asked = Scenario()
    asked.scene.splat = "splat.ply"
    asked.scene.unknown = None if unknown == "absent" else unknown
    (gate,) = unseen_gates(asked, unseen)
    assert gate.name == name
    assert gate.leads_to(False) == in_simulation
    # On the real robot a person has to accept that.
    assert gate.leads_to(True) == REFUSAL


def test_unseen_space_that_is_solid_or_nowhere_needs_no_gate():
    asked = Scenario()
    asked.scene.splat = "splat.ply"
    assert not unseen_gates(asked, 0.0)
    asked.scene.unknown = "obstacle"
    assert not unseen_gates(asked, 0.5)
    asked.oracle = GroundTruth()
    assert not unseen_gates(asked, None)


# Whole scenarios


def examined(spec: str, text: str = "") -> MapKnowledge:
    asked = load_scenario(spec, text)
    world = load_world(asked)
    places = target_places(asked, world) | saved_places(asked)
    return examine_map(asked, world, places)


MAPPED = [n for n in shipped_scenarios() if load_scenario(n).scene.splat]


@pytest.mark.parametrize("name", MAPPED)
def test_shipped_scenarios_have_nothing_wrong(name):
    knowledge = examined(name)
    assert all(g.leads_to(False) == SILENCE for g in knowledge.gates)
    # Their captures have seen most of the way.
    assert (knowledge.unseen or 0.0) < MOST_UNSEEN
    assert all(place.within_reach for place in knowledge.summary.places)


def test_targets_and_saved_poses_are_places():
    asked = load_scenario("TableTour")
    assert list(target_places(asked, load_world(asked))) == [
        "target 1",
        "target 2",
    ]
    poses = saved_places(load_scenario("TableTeleop"))
    np.testing.assert_array_equal(poses["pose 'over the table'"], [1, 0, 0.95])


SPLATS_AND_TRUTHS = {
    "table_0001": "table_new/table_new_0001",
    "table_0001_noise": "table_new/table_new_0001",
    "table_0001_floor": "table_new/table_new_0001",
    "table_0005": "table_new/table_new_0005",
    "bookshelf_0000": "bookshelf_cage/bookshelf_cage_0000",
    "bookshelf_0002": "bookshelf_cage/bookshelf_cage_0002",
}


@pytest.mark.parametrize("oracle", ["SphereToEllipsoid", "DepthRasterization"])
@pytest.mark.parametrize("name", list(SPLATS_AND_TRUTHS)[:: effort(2, 1)])
def test_trained_splats_raise_no_false_alarm(
    shared_data, tmp_path, name, oracle
):
    splat = shared_data / "splats" / f"{name}.ply"
    truth = shared_data / "rmmi_scenes" / f"{SPLATS_AND_TRUTHS[name]}.json"
    file = tmp_path / "a.yaml"
    file.write_text(f"A: {{scene: {{splat: {splat}, truth: {truth}}}}}\n")
    gates = examined(str(file), f"{{oracle: !{oracle} {{}}}}").gates
    # Neither their errors nor the space that their cameras saw are known.
    names = [gate.name for gate in gates]
    assert names == [UNKNOWN_MAP_ERROR, UNKNOWN_SEEN_SPACE]


def test_a_kitchen_full_of_faint_splats_raises_no_false_alarm(
    shared_data, tmp_path
):
    """A third of its splats are below 0.1, with 3 % of the opacity."""
    file = tmp_path / "kitchen.yaml"
    splat = shared_data / "redkitchen" / "redkitchen_noise.ply"
    file.write_text(
        "Kitchen:\n"
        f"  scene: {{splat: {splat}}}\n"
        "  robot: {base_pose: [0.3, -1.8, 1.5708]}\n"
        "  targets: [{translation: [0.12, -0.08, 0.92]}]\n"
    )
    knowledge = examined(str(file))
    assert knowledge.summary.faint > 15_000
    names = [gate.name for gate in knowledge.gates]
    assert names == [UNKNOWN_MAP_ERROR, UNKNOWN_SEEN_SPACE]


def test_true_geometry_that_is_elsewhere_is_told(tmp_path):
    box = Box(RigidTransform([8, 0, 1]), np.full(3, 0.1))
    write_rmmi(tmp_path / "scene.json", PrimitiveScene(boxes=(box,)))
    file = tmp_path / "a.yaml"
    file.write_text(
        "A:\n  scene: {truth: scene.json}\n  oracle: !GroundTruth {}\n"
        "  targets: [{translation: [7.5, 0, 1]}]\n"
    )
    (gate,) = examined(str(file)).gates
    assert gate.name == EMPTY_MAP and "of the start" in gate.problem
