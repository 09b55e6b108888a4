"""The selector as a system, beside the controller in the whole diagram."""

import copy
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from remosplat_drake.app.diagram import Application, build
from remosplat_drake.app.run_result import REACHED, TIME_LIMIT, RunResult
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import load_world
from remosplat_drake.controller import reactive_controller
from remosplat_drake.controller.guidance import guidance_selector
from remosplat_drake.controller.guidance.guidance_selector import (
    GuidanceSelector,
)
from remosplat_drake.controller.guidance.selection import Selection
from remosplat_drake.controller.guidance.selection_rule import (
    make_selection_rule,
)
from remosplat_drake.controller.program.solvers import ActiveSetSolver
from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi

STUCK = ("table", 6)
"""A scene of the published kind in which the controller alone gets stuck."""

TIGHT = ("table", 91796)
"""One in which only the smaller stopping distance arrives.

Without verification, the damper's rows would let a rollout slip past the
obstacle that stops the robot.
"""


@pytest.fixture
def application(tmp_path):
    """A function of a guidance setting that makes the application."""

    def make(
        guidance: str, limit: float = 12.0, scene: tuple[str, int] = STUCK
    ) -> Application:
        return build(*_load(tmp_path, guidance, limit, scene))

    return make


def _load(folder: Path, guidance: str, limit: float, scene: tuple[str, int]):
    write_rmmi(folder / "scene.json", generate(*scene))
    file = folder / "test.yaml"
    file.write_text(
        "Test:\n"
        "  scene: {truth: scene.json}\n"
        "  robot: {spheres: paper}\n"
        "  oracle: !GroundTruth {}\n"
        "  control_period: 0.05\n"
        f"  time_limit: {limit}\n"
        f"  controller: {{guidance: {guidance}}}\n"
    )
    scenario = load_scenario(str(file))
    return scenario, load_world(scenario)


def selector_of(application: Application) -> GuidanceSelector:
    (selector,) = (
        system
        for system in application.diagram.GetSystems()
        if isinstance(system, GuidanceSelector)
    )
    return selector


def watched(application: Application, until: float) -> list[Selection]:
    """All selections that the controller could have read."""
    selector = selector_of(application)
    simulator = Simulator(application.diagram)
    port = selector.GetOutputPort("selection")
    seen: list[Selection] = []
    for k in range(round(until / 0.05) + 1):
        simulator.AdvanceTo(0.05 * k)
        context = selector.GetMyContextFromRoot(simulator.get_context())
        seen.append(port.Eval(context))
    return seen


def test_where_the_controller_alone_is_stuck_guidance_arrives(application):
    alone: RunResult = run(application("{enabled: false}", 8.0))
    assert alone.outcome == TIME_LIMIT
    # Stuck, not slow: it stands.
    assert np.abs(alone.trajectory.u[-20:]).max() < 0.05
    guided = run(application("{}"))
    assert guided.outcome == REACHED
    clearance = guided.metrics.truth_clearance_min
    assert clearance is not None and clearance >= 0.021 - 1e-9


def test_beside_the_tick_it_looks_ahead_as_well(application):
    app = application("{asynchronous: true, budget_ms: 20}", 60.0)
    selector = selector_of(app)
    port = selector.GetOutputPort("selection")
    simulator = Simulator(app.diagram)
    simulator.set_target_realtime_rate(1.0)
    arriving = False
    # A busy computer may have no time for the other process for a while.
    while not arriving and simulator.get_context().get_time() < 60.0:
        simulator.AdvanceTo(simulator.get_context().get_time() + 0.1)
        context = selector.GetMyContextFromRoot(simulator.get_context())
        futures = port.Eval(context).latest
        arriving = any(rollout.status == "reached" for rollout in futures)
    assert arriving


def test_a_future_that_verification_would_stop_is_not_followed(application):
    guided = run(application("{tiers: [0.010]}", scene=TIGHT))
    assert guided.outcome == REACHED
    clearance = guided.metrics.truth_clearance_min
    assert clearance is not None and 0.010 - 1e-9 <= clearance < 0.021


def test_a_run_can_be_repeated_to_the_bit(application):
    first, second = (run(application("{}", 2.5)) for _ in range(2))
    np.testing.assert_array_equal(first.trajectory.u, second.trajectory.u)


def test_the_controller_follows_the_selection_one_period_late(
    application, monkeypatch
):
    followed, chosen = [], []
    run_tick = reactive_controller.run_tick

    def noting(*arguments, **options):
        followed.append(arguments[-1])
        return run_tick(*arguments, **options)

    monkeypatch.setattr(reactive_controller, "run_tick", noting)
    app = application("{}")
    selector = selector_of(app)
    port = selector.GetOutputPort("selection")
    simulator = Simulator(app.diagram)
    for k in range(50):
        simulator.AdvanceTo(0.05 * k + 0.025)
        context = selector.GetMyContextFromRoot(simulator.get_context())
        chosen.append(port.Eval(context).guidance)
    assert len(set(chosen)) > 1
    assert followed[1:] == chosen[:-1]


def test_selections_cross_the_port_uncopied(application):
    app = application("{}")
    seen = watched(app, 0.3)
    latest = seen[-1]
    assert copy.deepcopy(latest) is latest
    selector = selector_of(app)
    context = selector.CreateDefaultContext()
    port = selector.GetOutputPort("selection")
    assert port.Eval(context) is port.Eval(context)


def test_no_period_takes_more_steps_than_its_budget(application, counted):
    """But for the one that searches a path, and compares it at once."""
    at_once = "{budget: 4, planning: {at_once: false}}"
    simulator = Simulator(application(at_once).diagram)
    for k in range(20):
        before = len(counted)
        simulator.AdvanceTo(0.05 * k + 0.025)
        assert len(counted) - before <= 4
    assert len(counted) > 20


def test_without_a_budget_nothing_is_simulated(application, monkeypatch):
    def never(*arguments, **named):
        raise AssertionError("a rollout without a budget")

    monkeypatch.setattr(guidance_selector, "advance_selection", never)
    result = run(application("{budget: 0}", 6.0))
    reasons = {s.reason for s in watched(application("{budget: 0}"), 6.0)}
    assert "direct stalled" in reasons
    clearance = result.metrics.truth_clearance_min
    assert clearance is not None and clearance >= 0.021 - 1e-9


def test_without_guidance_there_is_no_selector(application):
    systems = application("{enabled: false}").diagram.GetSystems()
    assert not any(isinstance(s, GuidanceSelector) for s in systems)
    assert any(isinstance(s, ReactiveController) for s in systems)


def test_the_rule_has_every_candidate_of_every_tier(frankie):
    config = load_scenario(None, "{}").controller
    config.guidance.tiers = [0.010]
    law = ReactiveLaw.make(config, frankie, 0.01)
    rule = make_selection_rule(law, config.guidance, lambda error: False)
    q = np.array([0, 0, 0, *frankie.home])
    field = SignedDistanceField(PrimitiveScene())
    candidates = rule.candidates(q, np.eye(4), field)
    assert [[g.name for g in tier] for tier in candidates] == [
        ["direct", "left", "right"]
    ] * 2
    assert [tier[0].stopping for tier in candidates] == [0.021, 0.010]
    assert rule.start == candidates[0][0]
    assert rule.law.ingredients is law.ingredients
    assert isinstance(rule.law.solver, ActiveSetSolver)
    assert rule.law.dt == config.guidance.step == 0.1
    assert rule.horizon == 8.0
