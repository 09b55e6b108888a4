"""`scene.scale`: a splat in other units is the same scene, or is refused."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.app.diagram import build
from remosplat_drake.app.map_knowledge import examine_map, target_places
from remosplat_drake.app.run_result import REACHED
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import World, load_world
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.resources import models_dir
from remosplat_drake.commands.main import USER_ERROR, main
from remosplat_drake.splat.formats import read_splat, write_splat

TABLE = models_dir() / "scenes" / "table"

POSE = "X_WG: {translation: [0.1, -0.2, 0], rpy_deg: [0, 0, 30]}"


@pytest.fixture
def scenario(tmp_path) -> Path:
    """The shipped table in metres, and in thirds of a metre."""
    splat = read_splat(TABLE / "splat.ply").with_uncertainty(0.004)
    write_splat(tmp_path / "metres.ply", splat)
    write_splat(
        tmp_path / "thirds.ply", splat.transformed(RigidTransform(), 3.0)
    )
    path = tmp_path / "table.yaml"
    path.write_text(
        f"Table: {{scene: {{splat: metres.ply, truth: {TABLE}/scene.json}}}}\n"
    )
    return path


def world_of(scenario: Path, scene: str) -> World:
    return load_world(load_scenario(str(scenario), f"{{scene: {{{scene}}}}}"))


THIRDS = f"splat: thirds.ply, scale: {1 / 3}"


def test_a_scaled_splat_lies_where_the_metric_one_does(scenario):
    metric = world_of(scenario, POSE)
    scaled = world_of(scenario, f"{THIRDS}, {POSE}")
    assert metric.splat_W is not None and scaled.splat_W is not None
    np.testing.assert_allclose(
        scaled.splat_W.p_GK, metric.splat_W.p_GK, atol=1e-5
    )
    np.testing.assert_allclose(
        scaled.splat_W.uncertainty, metric.splat_W.uncertainty, rtol=1e-5
    )
    spheres = metric.robot.spheres_at(metric.q0)
    np.testing.assert_allclose(
        scaled.field.clearances(spheres).minimum(),
        metric.field.clearances(spheres).minimum(),
        atol=1e-5,
    )


def test_the_crop_box_stays_in_metres_of_the_world(scenario):
    crop = "crop: {lower: [-9, -9, 0.3], upper: [9, 9, 9]}"
    metric = world_of(scenario, crop)
    scaled = world_of(scenario, f"{THIRDS}, {crop}")
    assert metric.splat_W is not None and scaled.splat_W is not None
    assert abs(len(scaled.splat_W) - len(metric.splat_W)) < 5
    assert len(metric.cropped_W) > 1000


def test_a_run_in_a_scaled_splat_reaches_its_target(scenario):
    text = f"{{scene: {{{THIRDS}}}}}"
    application = build(load_scenario(str(scenario), text))
    assert run(application).outcome == REACHED


def test_the_wrong_unit_is_asked_about(scenario):
    given = load_scenario(str(scenario), "{scene: {scale: 0.001}}")
    world = load_world(given)
    knowledge = examine_map(given, world, target_places(given, world))
    (gate,) = (g for g in knowledge.gates if g.name == "empty-map")
    assert "check scene.X_WG, scene.scale and scene.crop" in gate.problem


@pytest.mark.parametrize("beside", ["seen", "quality.json"])
def test_what_was_measured_in_metres_is_not_scaled(scenario, beside):
    shutil.copy(
        TABLE / f"splat.{beside}", scenario.with_name(f"metres.{beside}")
    )
    with pytest.raises(FieldError) as caught:
        world_of(scenario, "scale: 1.5")
    assert caught.value.where == f"{scenario}:Table"
    assert caught.value.field == "scene.scale"
    assert caught.value.problem.startswith(
        f"must be 1, got 1.5: metres.{beside} requires a splat in metres"
    )


@pytest.mark.parametrize("scale", ["0", "-1", ".nan", "1e9", "two"])
def test_scales_that_cannot_be(scenario, scale, capfd):
    words = ["run", str(scenario), "--headless"]
    text = f"{{scene: {{scale: {scale}}}}}"
    assert main([*words, "--scenario-text", text]) == USER_ERROR
    error = capfd.readouterr().err
    assert "--scenario-text:1: scene.scale: " in error
    assert error.count("\n") == 1
