"""Look-ahead beside the tick: real processes, which may be lost."""

import copy
import dataclasses as dc
import operator
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from time import monotonic, perf_counter, sleep

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.guidance import look_ahead_process
from remosplat_drake.controller.guidance.guidance_selector import updated
from remosplat_drake.controller.guidance.look_ahead_process import (
    DIED,
    LookAheadProcess,
)
from remosplat_drake.controller.guidance.present_state import PresentState
from remosplat_drake.controller.guidance.rollout import STRIDE
from remosplat_drake.controller.guidance.selection import (
    Selection,
    start_selection,
)
from remosplat_drake.controller.guidance.selection_rule import (
    SelectionRule,
    make_selection_rule,
)
from remosplat_drake.controller.guidance.worker import look_ahead
from remosplat_drake.controller.program.ingredient import Ingredient
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.aim import Aim
from remosplat_drake.task.arrival import ArrivalConfig, has_arrived

ARRIVED = partial(has_arrived, config=ArrivalConfig())
BUDGET = 0.008
LONG = 600.0


@dc.dataclass(frozen=True)
class Stuck:
    """A robot that gets stuck if it goes straight.

    Attributes:
        rule: What the selector tries.
        field: The map.
        now: The robot's first state.
    """

    rule: SelectionRule
    field: SignedDistanceField
    now: PresentState


@pytest.fixture(scope="module")
def stuck(frankie) -> Stuck:
    scene = generate("table", 6)
    assert scene.X_WE_target is not None and scene.X_WB_start is not None
    return Stuck(
        make_rule(frankie),
        SignedDistanceField(scene),
        PresentState(
            0.0,
            np.array([*scene.X_WB_start, *frankie.home]),
            np.zeros(frankie.n_u),
            Aim.of(scene.X_WE_target),
        ),
    )


@pytest.fixture(scope="module")
def shared_process(frankie, stuck) -> Iterator[LookAheadProcess]:
    process = LookAheadProcess(make_rule(frankie), BUDGET, stuck.field)
    yield process
    process.close()
    assert not process.process.is_alive()
    process.close()  # Once more does no harm.


def make_rule(
    frankie, *ingredients: Ingredient, arrived: Callable = ARRIVED
) -> SelectionRule:
    config = gain_set("tuned")
    law = ReactiveLaw.make(config, frankie, 0.01, ingredients)
    return make_selection_rule(law, config.guidance, arrived)


def until(process, stuck, good, now=None, field=None) -> Selection:
    """Updates for a robot that stands still, until the selection is good."""
    selection, now = start_selection(stuck.rule), now or stuck.now
    end = monotonic() + LONG
    while monotonic() < end:
        # Nothing that has been decided holds for longer than a second.
        now = dc.replace(now, time=monotonic())
        selection = updated(
            process, stuck.rule, selection, now, field or stuck.field
        )
        if good(selection):
            return selection
        sleep(0.005)
    raise AssertionError(f"nothing but {selection.reason!r}")


def test_it_decides_what_the_selector_would_decide(shared_process, stuck):
    found = until(shared_process, stuck, lambda s: s.latest)
    here = look_ahead(
        stuck.rule,
        start_selection(stuck.rule),
        stuck.now,
        stuck.field,
        perf_counter() + LONG,
        lambda: False,
    )
    assert found.guidance == here.guidance
    assert found.guidance.name != "direct"
    assert found.reason == here.reason
    assert not found.missing
    for theirs, ours in zip(found.latest, here.latest, strict=True):
        np.testing.assert_array_equal(theirs.path, ours.path)


def test_it_hears_of_what_moves(shared_process, stuck):
    ada = Mover.sphere("Ada", [9.0, 0.0, 1.0], 0.2, v_WM=[0.5, 0.0, 0.0])
    X_WT = stuck.now.aim.first.X_WT.copy()
    X_WT[2, 3] += 0.01
    movers = Movers(monotonic(), [ada])
    now = dc.replace(stuck.now, aim=Aim.of(X_WT), movers=movers)
    found = until(shared_process, stuck, lambda s: s.latest, now)
    for rollout in found.latest:
        assert [m.name for m in rollout.movers or ()] == ["Ada"]


def test_a_new_target_and_a_new_map_are_answered_for(shared_process, stuck):
    until(shared_process, stuck, lambda s: s.latest)
    X_WT = stuck.now.aim.first.X_WT.copy()
    X_WT[2, 3] += 0.4
    elsewhere = dc.replace(stuck.now, aim=Aim.of(X_WT))
    found = until(shared_process, stuck, lambda s: s.latest, now=elsewhere)
    np.testing.assert_array_equal(found.aim.first.X_WT, X_WT)
    other = copy.copy(stuck.field)
    other.revision = "another"
    found = until(
        shared_process, stuck, lambda s: s.latest, now=elsewhere, field=other
    )
    assert found.revision == "another"


def test_an_answer_about_another_world_is_dropped(shared_process, stuck):
    until(shared_process, stuck, lambda s: s.latest)
    other = copy.copy(stuck.field)
    other.revision = "a third"
    start = start_selection(stuck.rule)
    # The rollouts under way now are about the map before.
    for _ in range(20):
        selection = updated(shared_process, stuck.rule, start, stuck.now, other)
        assert selection.revision == "a third"
        sleep(0.01)


def test_a_lost_measurement_changes_nothing(shared_process, stuck):
    selection = start_selection(stuck.rule)
    lost = dc.replace(stuck.now, q=np.full_like(stuck.now.q, np.nan))
    assert (
        updated(shared_process, stuck.rule, selection, lost, stuck.field)
        is selection
    )


def test_interrupted_it_stops_after_a_few_steps(stuck):
    asked = []

    def interrupted() -> bool:
        asked.append(True)
        return len(asked) > 3

    selection = look_ahead(
        stuck.rule,
        start_selection(stuck.rule),
        stuck.now,
        stuck.field,
        perf_counter() + LONG,
        interrupted,
    )
    assert [r.num_steps for r in selection.running] == [3 * STRIDE]


def test_without_its_process_it_cycles_and_says_why(frankie, stuck):
    process = LookAheadProcess(make_rule(frankie), BUDGET, stuck.field)
    until(process, stuck, lambda s: s.latest)
    process.process.kill()
    selection = until(process, stuck, lambda s: s.missing == DIED)
    # The robot stands: the next candidate's turn comes.
    later = dc.replace(stuck.now, time=monotonic() + 10.0)
    following = updated(process, stuck.rule, selection, later, stuck.field)
    assert following.guidance is not selection.guidance
    assert following.missing == DIED


def test_while_its_process_hangs_it_cycles(frankie, stuck, monkeypatch):
    process = LookAheadProcess(make_rule(frankie), BUDGET, stuck.field)
    until(process, stuck, lambda s: s.latest)
    pid = process.process.pid
    assert pid is not None
    os.kill(pid, signal.SIGSTOP)
    with monkeypatch.context() as impatient:
        impatient.setattr(look_ahead_process, "PATIENCE", 0.05)
        selection = until(process, stuck, lambda s: s.missing)
    assert "has not answered" in selection.missing
    later = dc.replace(stuck.now, time=monotonic() + 10.0)
    following = updated(process, stuck.rule, selection, later, stuck.field)
    assert following.guidance is not selection.guidance
    os.kill(pid, signal.SIGCONT)
    assert not until(process, stuck, lambda s: not s.missing).missing


def test_an_error_inside_is_named(frankie, stuck):
    never = partial(operator.truediv, 1.0)
    process = LookAheadProcess(
        make_rule(frankie, arrived=never), BUDGET, stuck.field
    )
    selection = until(process, stuck, lambda s: "failed" in s.missing)
    assert selection.missing.startswith("look-ahead failed: TypeError")


class Unpicklable:
    """An ingredient that holds a lambda."""

    def __init__(self):
        self.weight = lambda: 1.0

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        program.add_linear_cost("mine", np.full(program.n_u, self.weight()))


def test_what_cannot_be_sent_is_named(frankie, stuck):
    match = "^Unpicklable cannot be sent to the look-ahead .* be pickled"
    with pytest.raises(RemoSplatError, match=match):
        LookAheadProcess(make_rule(frankie, Unpicklable()), BUDGET, stuck.field)


def test_what_was_typed_into_a_notebook_is_named():
    """Its class is nowhere to be found for another process."""
    typed = """
from functools import partial
from remosplat_drake.controller.guidance.guidance_config import GuidanceConfig
from remosplat_drake.controller.guidance.look_ahead_process import (
    LookAheadProcess,
)
from remosplat_drake.controller.guidance.selection_rule import (
    make_selection_rule,
)
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.task.arrival import ArrivalConfig, has_arrived

class MyCost:
    def AddToProgram(self, program, tick):
        pass

law = ReactiveLaw(load_robot("frankie", "paper"), [MyCost()])
arrived = partial(has_arrived, config=ArrivalConfig())
try:
    rule = make_selection_rule(law, GuidanceConfig(), arrived)
    LookAheadProcess(rule, 1.0, SignedDistanceField(PrimitiveScene()))
except Exception as error:
    print(error)
"""
    answer = subprocess.run(
        [sys.executable, "-c", typed], capture_output=True, text=True
    )
    assert answer.stdout.startswith(
        "MyCost cannot be sent to the look-ahead process: it cannot be imported"
    ), answer.stderr
    assert answer.stdout.count("\n") == 1


def test_a_process_that_is_killed_while_it_searches_is_missed(frankie, stuck):
    """What it searches is behind walls, which a search never finds out."""
    config = gain_set("tuned")
    config.guidance.planning.checks = 10_000_000
    law = ReactiveLaw.make(config, frankie, 0.01)
    rule = make_selection_rule(law, config.guidance, ARRIVED)
    target = stuck.now.aim.first.X_WT[:3, 3]
    walls = tuple(
        Box(
            RigidTransform([*target[:2] + 2.0 * np.array(side), 0]),
            np.array([0.1 + 2 * abs(side[1]), 0.1 + 2 * abs(side[0]), 3]),
        )
        for side in ((1, 0), (-1, 0), (0, 1), (0, -1))
    )
    field = SignedDistanceField(PrimitiveScene(boxes=walls))
    q = stuck.now.q.copy()
    q[:2] = target[:2] + np.array([5.0, 0.0])
    now = dc.replace(stuck.now, q=q)
    process = LookAheadProcess(rule, BUDGET, field)
    until(
        process,
        stuck,
        lambda s: process.missing.startswith("look-ahead has not answered"),
        now,
        field,
    )
    os.kill(process.process.pid, signal.SIGKILL)
    selection = until(process, stuck, lambda s: s.missing == DIED, now, field)
    assert selection.guidance.path is None
    process.close()
