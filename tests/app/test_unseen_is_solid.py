"""The seen space of a scenario's splat: its file, its place, its effect."""

from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.app.diagram import build
from remosplat_drake.app.hardware_run import prepare_for_hardware
from remosplat_drake.app.run_result import REACHED
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.scene_config import OBSTACLE
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import World, load_world
from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.resources import models_dir
from remosplat_drake.commands.main import USER_ERROR, main
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.reconstruction.seen_file import (
    read_seen_space,
    seen_path,
    write_seen_space,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.coverage import UNSEEN

TABLE = models_dir() / "scenes" / "table"


@pytest.fixture
def table(tmp_path) -> Path:
    """The shipped table in a folder of its own, with what was seen of it."""
    for name in ("splat.ply", "splat.seen", "splat.quality.json"):
        (tmp_path / name).write_bytes((TABLE / name).read_bytes())
    (tmp_path / "table.yaml").write_text(
        f"Table: {{scene: {{splat: splat.ply, truth: {TABLE}/scene.json}}}}\n"
    )
    return tmp_path / "table.yaml"


def world_of(table: Path, scene: str = "{}") -> World:
    return load_world(load_scenario(str(table), f"{{scene: {scene}}}"))


def hide(table: Path, lower: list[float], upper: list[float]) -> None:
    """Makes a box unseen by all cameras."""
    splat = table.with_name("splat.ply")
    coverage = read_seen_space(seen_path(splat), splat)
    low, high = (
        np.round((np.array(p) - coverage.lower) / coverage.voxel).astype(int)
        for p in (lower, upper)
    )
    coverage.state[tuple(map(slice, low, high))] = UNSEEN
    write_seen_space(splat, coverage)


def test_unseen_space_is_solid_only_where_the_scenario_says_so(table):
    solid = world_of(table, "{unknown: obstacle}")
    assert isinstance(solid.field, CompositeDistanceField)
    for scene in ("{}", "{unknown: warn}", "{unknown: free}"):
        free = world_of(table, scene)
        assert not isinstance(free.field, CompositeDistanceField)
        assert free.seen is not None
    assert solid.field.parts[0].revision == free.field.revision


def test_on_hardware_it_is_solid_unless_a_choice_was_made(table):
    scenario = load_scenario(str(table))
    prepare_for_hardware(scenario, None)
    assert scenario.scene.unknown == OBSTACLE
    scenario = load_scenario(str(table), "{scene: {unknown: free}}")
    prepare_for_hardware(scenario, None)
    assert scenario.scene.unknown == "free"


def test_the_robot_may_stand_where_it_starts(table):
    """No camera has looked there; beyond the margin it stays unknown."""
    hide(table, [-1.0, -1.0, 0.0], [0.4, 1.0, 1.5])
    world = world_of(table, "{unknown: obstacle}")
    assert world.seen is not None
    at_start = world.robot.spheres_at(world.q0)
    assert world.seen.field.clearances(at_start).minimum() > 0.2
    corner = world.seen.field.clearances(Spheres.at([-0.9, 0.9, 1.0]))
    assert corner.minimum() < 0


def test_what_is_hidden_stops_the_robot(table):
    """A slab of air before the table is enough."""
    hide(table, [0.9, -1.0, 0.1], [1.0, 1.0, 1.3])
    text = (
        "{scene: {unknown: obstacle}, time_limit: 4,"
        " controller: {guidance: {enabled: false}}}"
    )
    application = build(load_scenario(str(table), text))
    stopped = run(application)
    assert stopped.outcome != REACHED
    assert stopped.metrics.unseen_clearance_min == pytest.approx(
        0.021, abs=2e-3
    )
    assert stopped.metrics.unseen_ticks == 0
    free = run(build(load_scenario(str(table))))
    assert free.outcome == REACHED
    assert free.metrics.unseen_ticks > 0
    assert free.metrics.unseen_clearance_min < 0


def test_it_moves_with_the_splat(table):
    rpy = [0, 0, 90]
    X_WG = f"{{translation: [-0.2, 0.3, 0.01], rpy_deg: {rpy}}}"
    here = world_of(table).seen
    there = world_of(table, f"{{X_WG: {X_WG}}}").seen
    assert here is not None and there is not None
    p_G = np.random.default_rng(0).uniform([0.6, -1, 0.1], [2, 1, 1.5], (50, 3))
    p_W = there.X_WG.multiply(p_G.T).T
    np.testing.assert_allclose(
        there.field.clearances(Spheres.at(p_W)).distance,
        here.field.clearances(Spheres.at(p_G)).distance,
        atol=1e-6,
    )


def test_surfaces_that_are_cropped_away_are_not_known(table):
    whole = world_of(table).seen
    crop = "{crop: {lower: [-9, -9, -9], upper: [9, 9, 0.3]}}"
    cropped = world_of(table, crop).seen
    assert whole is not None and cropped is not None
    box = [np.array([0.6, -0.5, 0.3]), np.array([1.6, 0.5, 0.8])]
    assert cropped.unseen_fraction(box) > whole.unseen_fraction(box) + 0.02
    floor = [np.array([-0.5, -0.5, 0.0]), np.array([0.3, 0.5, 0.0])]
    assert cropped.unseen_fraction(floor) == whole.unseen_fraction(floor)


def test_outside_of_the_grid_space_is_unseen(table):
    seen = world_of(table).seen
    assert seen is not None
    away = [np.array([40.0, 0, 0]), np.array([41.0, 0, 1])]
    assert seen.unseen_fraction(away) == 1.0


def test_a_target_in_unseen_space_is_named(table, capsys):
    text = (
        "{scene: {unknown: obstacle}, time_limit: 0.1,"
        " targets: [{translation: [1.0, 0.0, 0.3]}]}"
    )
    hide(table, [0.8, -0.2, 0.2], [1.2, 0.2, 0.4])
    assert main(["run", str(table), "--headless", "--scenario-text", text])
    told = capsys.readouterr().err.replace("\n", " ")
    assert "it counts as obstacle; target 1 lies in it" in told


def test_the_true_geometry_needs_no_camera(table):
    text = "{scene: {unknown: obstacle}, oracle: !GroundTruth {}}"
    assert load_world(load_scenario(str(table), text)).seen is None


def test_a_file_may_be_named(table):
    moved = table.with_name("elsewhere.seen")
    table.with_name("splat.seen").rename(moved)
    assert world_of(table).seen is None
    assert world_of(table, "{seen: elsewhere.seen}").seen is not None
    with pytest.raises(FieldError, match=r"scene\.seen: nowhere\.seen"):
        world_of(table, "{seen: nowhere.seen}")


def test_a_stale_file_is_refused(table):
    splat = table.with_name("splat.ply")
    splat.write_bytes((TABLE.parent / "bookshelf" / "splat.ply").read_bytes())
    with pytest.raises(FileError, match="another splat"):
        world_of(table)


def test_nothing_seen_and_nothing_to_pass_through_ends_in_one_line(
    table, capsys
):
    table.with_name("splat.seen").unlink()
    text = "{scene: {unknown: obstacle}}"
    arguments = ["run", str(table), "--headless", "--scenario-text", text]
    assert main(arguments) == USER_ERROR
    *_, line = capsys.readouterr().err.splitlines()
    assert "remosplat reconstruct" in line
    assert "--accept unknown-seen-space" in line
