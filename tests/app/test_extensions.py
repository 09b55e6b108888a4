"""Parts that a package of others adds, without an edit in ours."""

import dataclasses as dc
import json
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from remosplat_drake.app.diagram import Application, build
from remosplat_drake.app.run_result import REACHED
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.scenario_text import scenario_text
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import load_world
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.benchmark.methods import Method
from remosplat_drake.commands.main import main
from remosplat_drake.controller.guidance.guidance_selector import (
    GuidanceSelector,
)
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi

EXAMPLES = Path(__file__).resolve().parents[2] / "apps" / "examples"
OUTSIDE = Path(__file__).resolve().parents[1] / "data" / "outside"

COMMAND_LINE = (
    "import sys; from remosplat_drake.commands.main import main;"
    " sys.exit(main(sys.argv[1:]))"
)


@pytest.fixture
def outside(monkeypatch) -> None:
    """Lets Python find the other package."""
    monkeypatch.syspath_prepend(str(OUTSIDE))


@pytest.fixture
def load(tmp_path, outside):
    """A function of YAML that gives its scenario, with a box far away."""
    box = Box(RigidTransform([-1.5, 0, 0.5]), np.array([0.1, 0.5, 0.5]))
    write_rmmi(tmp_path / "scene.json", PrimitiveScene(boxes=(box,)))

    def make(text: str = "", override: str = "") -> Scenario:
        (tmp_path / "mine.yaml").write_text(
            "Mine:\n"
            "  scene: {truth: scene.json}\n"
            "  control_period: 0.05\n"
            "  time_limit: 4\n"
            "  oracle: !GroundTruth {}\n"
            "  targets: !outside.targets:Ahead {}\n" + text
        )
        return load_scenario(f"{tmp_path}/mine.yaml:Mine", override)

    return make


def made(scenario: Scenario, **arguments) -> Application:
    return build(scenario, load_world(scenario), **arguments)


def turned(application: Application) -> float:
    """How far the arm's first joint has turned after half a second [rad]."""
    scenario = application.scenario
    scenario.time_limit = 0.5
    q = run(application, until=lambda error: False).trajectory.q
    return q[-1, 3] - q[0, 3]


def test_a_cost_acts(load):
    extra = "  controller: {extra: [!outside.cost:Drift {gain: 3}]}\n"
    assert turned(made(load(extra))) < turned(made(load())) - 0.02


def test_a_cost_from_python_acts_likewise(load):
    from outside.cost import Drift

    extra = "  controller: {extra: [!outside.cost:Drift {gain: 3}]}\n"
    listed = made(load(), ingredients=[Drift(gain=3)])
    assert turned(listed) == turned(made(load(extra)))


def test_a_compiled_cost_acts_likewise(load):
    text = "  controller: {extra: [!outside.cost:%s {gain: 3}]}\n"
    compiled, in_python = (
        made(load(text % kind)) for kind in ("CompiledDrift", "Drift")
    )
    assert turned(compiled) == turned(in_python)


def test_a_cost_that_is_not_a_number_stops_the_robot_by_name(load):
    extra = "  controller: {extra: [!outside.broken:NotANumber {}]}\n"
    result = run(made(load(extra)))
    assert result.outcome == (
        "stopped: no command for 1 s:"
        " ingredient NotANumber: linear cost 'nan': c is not finite"
    )
    q = result.trajectory.q
    np.testing.assert_array_equal(q[-1], q[0])


def test_a_cost_that_raises_ends_a_run_with_its_file_and_line(load, capfd):
    extra = "  controller: {extra: [!outside.broken:Raises {}]}\n"
    scenario = load(extra)
    assert main(["run", scenario.source, "--headless"]) == 2
    said = capfd.readouterr().err.strip().splitlines()[-1]
    assert "ingredient Raises raised ZeroDivisionError: " in said
    assert said.endswith("broken.py:23)")


def test_an_ingredient_may_be_made_for_the_robot(load):
    extra = "  controller: {extra: [outside.cost:DriftOf]}\n"
    scenario = load(extra)
    from outside.cost import Drift

    listed = made(load(), ingredients=[Drift(gain=4.5)])
    assert turned(listed) == turned(made(scenario))


def selector_of(application: Application) -> GuidanceSelector:
    (selector,) = (
        system
        for system in application.diagram.GetSystems()
        if isinstance(system, GuidanceSelector)
    )
    return selector


def first_rollout(scenario: Scenario) -> np.ndarray:
    """Where the first rollout of a run leads the end effector, (k, 3)."""
    application = made(scenario)
    selector = selector_of(application)
    simulator = Simulator(application.diagram)
    # Another process needs time of its own, on a busy computer a lot of it.
    simulator.set_target_realtime_rate(1.0)
    context = selector.GetMyContextFromRoot(simulator.get_context())
    for end in np.arange(0.05, 120.0, 0.05):
        simulator.AdvanceTo(end)
        selection = selector.GetOutputPort("selection").Eval(context)
        if selection.latest:
            return np.array(selection.latest[0].path)
    raise AssertionError("no rollout has ended")


@pytest.mark.parametrize(
    ("kind", "beside"),
    [
        ("Drift", False),
        ("CompiledDrift", True),
        pytest.param("Drift", True, marks=pytest.mark.slow),
        pytest.param("CompiledDrift", False, marks=pytest.mark.slow),
    ],
)
def test_a_cost_acts_in_rollouts(load, beside, kind):
    """In the look-ahead's own process, too."""
    text = (
        "  controller: {guidance: {asynchronous: %s, horizon: 0.5,"
        " planning: {enabled: false}}%s}\n"
    )
    switch = str(beside).lower()
    extra = f", extra: [!outside.cost:{kind} {{gain: 3}}]"
    # So far away that the robot still drives when a slow process has started.
    far = "{targets: !outside.targets:Ahead {distance: 90}}"
    plain = first_rollout(load(text % (switch, ""), far))
    pushed = first_rollout(load(text % (switch, extra), far))
    # The target lies straight ahead; the cost turns the arm aside.
    assert np.abs(plain[:, 1]).max() < 1e-9
    assert pushed[:, 1].min() < -1e-3


def test_the_same_cost_twice_is_refused_in_one_line(load, tmp_path, capsys):
    load("  controller: {extra: [outside.cost:Drift, outside.cost:Drift]}\n")
    assert main(["run", f"{tmp_path}/mine.yaml:Mine", "--headless"]) == 2
    error = capsys.readouterr().err.strip()
    assert "there is a linear cost 'drift' already" in error
    assert len(error.splitlines()) == 1


def test_an_oracle_keeps_the_robot_away(load):
    plain = load_world(load())
    padded = load_world(
        load(override="{oracle: !outside.oracle:Padded {margin: 0.3}}")
    )
    spheres = plain.robot.spheres_at(plain.q0)
    distances = [
        world.field.clearances(spheres).minimum() for world in (plain, padded)
    ]
    assert distances[1] == pytest.approx(distances[0] - 0.3)


def test_an_oracle_must_make_a_field(load):
    with pytest.raises(FieldError, match="oracle: Nothing must make a Dist"):
        load_world(load(override="{oracle: outside.oracle:Nothing}"))


def test_an_oracle_must_know_how_near_the_robot_starts(load):
    with pytest.raises(FieldError, match="oracle: measures no distance"):
        load_world(load(override="{oracle: outside.oracle:Blind}"))


def test_a_station_from_outside_is_driven(load):
    application = made(load("  station: outside.station:Elsewhere\n"))
    assert application.station.get_name() == "elsewhere"
    assert run(application).outcome == REACHED


def test_a_station_without_the_ports_is_refused(load):
    with pytest.raises(RemoSplatError) as refused:
        made(load("  station: outside.station:Stump\n"))
    message = str(refused.value)
    assert "mine.yaml:Mine: station: Stump: " in message
    assert "has no input panda.velocity_commanded" in message
    assert "has no output status" in message
    assert "has an unknown output temperature" in message
    assert (
        "output panda.position_measured: expected a vector of 7, got a"
        " vector of 1" in message
    )
    assert "cheat" not in message


def test_a_planner_decides_what_is_tried(load):
    from outside.planner import RightOnly

    scenario = load(
        "  controller: {guidance: {planner: outside.planner:RightOnly,"
        " horizon: 0.2}}\n"
    )
    assert scenario.controller.guidance.planner == RightOnly()
    application = made(scenario)
    port = selector_of(application).GetOutputPort("selection")
    simulator = Simulator(application.diagram)
    context = selector_of(application).GetMyContextFromRoot(
        simulator.get_context()
    )
    simulator.AdvanceTo(0.1)  # The first round; a later one may arrive.
    names = [r.guidance.name for r in port.Eval(context).latest]
    # Where neither arrives, a path is planned, for any planner.
    assert names[:2] == ["direct", "keep right"]
    assert set(names[2:]) <= {"plan"}


def test_targets_from_outside_are_reached(load):
    result = run(made(load()))
    assert (result.outcome, result.targets) == (REACHED, 1)


def test_a_system_that_hands_out_no_targets_is_refused(load):
    scenario = load(override="{targets: outside.targets:Nowhere}")
    match = "Mine: Nowhere lacks the method progress, .*, the output target"
    with pytest.raises(RemoSplatError, match=match):
        made(scenario)


BAD = {
    "module": ("outsied.cost:Drift", "cannot import outsied.cost: Module"),
    "class": ("outside.cost:Dritf", "did you mean 'Drift'"),
    "name": ("Drift", "expected package.module:Class"),
    "kind": ("outside.oracle:Padded", r"has no method AddToProgram\(program,"),
    "no config": ("outside.oracle:PaddedField", "derived from Config"),
    "field": ("!outside.cost:Drift {gian: 1}", "did you mean 'gain'"),
    "range": ("!outside.cost:Drift {gain: 11}", r"gain: must lie in \[-10"),
    "value": ("!outside.cost:Drift {gain: much}", "gain: expected a number"),
}


@pytest.mark.parametrize("value", BAD)
def test_what_is_wrong_is_named_with_its_line(load, value):
    text, problem = BAD[value]
    match = rf"mine\.yaml:9: controller\.extra\[0\].*{problem}"
    with pytest.raises(FieldError, match=match):
        load(f"  controller:\n    extra:\n    - {text}\n")


def test_from_python_the_wrong_kind_is_refused(load):
    scenario = load()
    from outside.oracle import Padded

    for extra in (Padded(), 3):
        scenario.controller.extra = [extra]
        with pytest.raises(FieldError, match=r"controller\.extra\[0\]: "):
            made(scenario)


def test_a_module_beside_the_file_is_found_but_hides_nothing(load, tmp_path):
    cost = (OUTSIDE / "outside" / "cost.py").read_text()
    (tmp_path / "beside_the_file.py").write_text(cost)
    (tmp_path / "outside.py").write_text("raise AssertionError")
    text = "  controller: {extra: [%s:Drift]}\n"
    (extra,) = load(text % "beside_the_file").controller.extra
    assert type(extra).__module__ == "beside_the_file"
    (extra,) = load(text % "outside.cost").controller.extra
    assert type(extra).__module__ == "outside.cost"


def test_it_survives_being_written_sent_and_named(load, tmp_path):
    scenario = load(
        "  controller: {extra: [!outside.cost:Drift {gain: 2}]}\n"
        "  station: !outside.station:Elsewhere {name: there}\n",
        "{oracle: !outside.oracle:Padded {margin: 0.2}}",
    )
    folder = tmp_path / "session"
    folder.mkdir()
    (folder / "copy.yaml").write_text(scenario_text(scenario, "Mine"))
    again = load_scenario(f"{folder}/copy.yaml:Mine")
    assert again.modules == str(tmp_path)
    again.source, again.modules = scenario.source, ""
    again.scene.truth = scenario.scene.truth
    assert again == scenario
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    others = dc.replace(scenario, oracle=type(scenario.oracle)(0.3))
    keys = {Method("mine", s).fingerprint for s in (scenario, again, others)}
    assert len(keys) == 2


def test_the_command_runs_a_cost_that_lies_beside_the_scenario(tmp_path):
    """One file, no edit elsewhere, in a process that knows nothing of it."""
    shutil.copy(EXAMPLES / "04_add_a_cost.py", tmp_path / "stand_still.py")
    (tmp_path / "mine.yaml").write_text(
        "Still:\n"
        "  scene: {truth: package://remosplat_drake/models/scenes/table"
        "/scene.json}\n"
        "  oracle: !GroundTruth {}\n"
        "  controller:\n"
        "    extra:\n"
        "    - !stand_still:StandStill {weight: 100}\n"
        "  time_limit: 1\n"
    )
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    travelled = []
    for text in ("{}", "{controller: {extra: []}}"):
        command = [
            *(sys.executable, "-c", COMMAND_LINE, "run", "--headless"),
            *(f"{tmp_path}/mine.yaml:Still", "--scenario-text", text),
            *("--output", "run"),
        ]
        subprocess.run(command, cwd=elsewhere, capture_output=True)
        metrics = json.loads((elsewhere / "run" / "metrics.json").read_text())
        travelled.append(metrics["base_path_length"])
    assert travelled[0] < 0.5 * travelled[1]
