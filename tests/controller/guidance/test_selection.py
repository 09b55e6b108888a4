"""The selector's rule (which guidance, when) on a world small enough to know.

`far` stalls before the toy world's target, `near` arrives after about 17
steps. No rollout is replaced by anything: steps are only counted.
"""

import copy
import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.controller.guidance.rollout import REACHED, STALLED
from remosplat_drake.controller.guidance.selection import (
    Selection,
    start_selection,
)
from remosplat_drake.controller.guidance.selection_round import (
    IDLE,
    PATIENCE,
    advance_selection,
)
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.planning.planning_config import PlanningConfig
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target

PLENTY = 1000


def advance(rule, selection, toy, *, time=0.0, budget=PLENTY, **changes):
    """One update for a robot that stands at the toy world's start."""
    arguments = {
        "q": toy.q,
        "u": np.zeros(3),
        "aim": toy.X_WT,
        "field": toy.field,
        **changes,
    }
    return advance_selection(
        rule, selection, time=time, budget=budget, **arguments
    )


def names(selection: Selection) -> list[str]:
    return [rollout.guidance.name for rollout in selection.latest]


def test_a_task_starts_with_the_first_candidate(toy):
    assert start_selection(toy.rule((toy.far, toy.near))).guidance is toy.far
    assert start_selection(toy.rule()).guidance == Guidance()


def test_what_arrives_is_kept_and_trusted_for_a_second(toy, counted):
    rule = toy.rule((toy.near, toy.far))
    selection = advance(rule, start_selection(rule), toy, time=3.0)
    assert selection.guidance is toy.near
    assert names(selection) == ["near"]
    assert selection.idle_until == 3.0 + IDLE
    assert set(counted) == {toy.near}
    steps = len(counted)
    again = advance(rule, selection, toy, time=3.0 + IDLE - 1e-6)
    assert again is selection
    assert len(counted) == steps
    advance(rule, selection, toy, time=3.0 + IDLE, budget=1)
    assert len(counted) == steps + 1


def test_what_does_not_arrive_is_replaced_by_what_does(toy):
    rule = toy.rule((toy.far, toy.near))
    selection = advance(rule, start_selection(rule), toy)
    assert selection.guidance is toy.near
    assert selection.reason == "far stalled, near reached"
    assert [rollout.status for rollout in selection.latest] == [
        STALLED,
        REACHED,
    ]
    assert selection.idle_until == IDLE


@pytest.mark.parametrize("budget", [1, 7, 10])
def test_the_budget_is_spent_to_the_step(toy, counted, budget):
    rule = toy.rule((toy.far, toy.near))
    selection = start_selection(rule)
    for update in range(1, 60):
        before = len(counted)
        selection = advance(rule, selection, toy, budget=budget)
        if selection.latest:
            assert 1 <= len(counted) - before <= budget
            break
        assert len(counted) == budget * update
    # The robot has stood still meanwhile: any split decides the same.
    whole = advance(rule, start_selection(rule), toy)
    assert selection.guidance is whole.guidance is toy.near
    assert len(counted) == 2 * sum(len(r.path) for r in whole.latest)


def test_nothing_is_decided_before_all_of_a_tier_is_known(toy):
    rule = toy.rule((toy.far, toy.near))
    selection = start_selection(rule)
    for _ in range(10):
        selection = advance(rule, selection, toy, budget=2)
        assert selection.guidance is toy.far
    assert selection.running


def test_candidates_start_where_the_robot_is_when_their_turn_comes(toy):
    rule = toy.rule((toy.far, toy.near))
    selection = start_selection(rule)
    while not selection.finished:
        selection = advance(rule, selection, toy, budget=1)
    # `near` waits at the old state: it has not taken a step.
    (near,) = selection.running
    assert near.guidance is toy.near
    np.testing.assert_array_equal(near.q, toy.q)
    moved = toy.q + 0.1
    selection = start_selection(rule)
    while not selection.finished:
        selection = advance(rule, selection, toy, budget=1, q=moved)
    (near,) = selection.running
    np.testing.assert_array_equal(near.q, moved)


def test_a_lower_tier_is_tried_only_if_the_first_has_nothing(toy):
    closest = Guidance("closest", stopping=0.001)
    rule = toy.rule((toy.far, toy.near), (closest,))
    selection = advance(rule, start_selection(rule), toy)
    assert names(selection) == ["far", "near"]
    assert selection.guidance is toy.near

    aside = dc.replace(toy.far, name="aside", side=1.0)
    rule = toy.rule((toy.far, aside), (toy.near,))
    selection = advance(rule, start_selection(rule), toy)
    assert names(selection) == ["far", "aside", "near"]
    assert selection.guidance is toy.near


def test_from_a_lower_tier_the_first_is_tried_first(toy):
    stuck = dc.replace(toy.far, name="stuck", stopping=0.029)
    rule = toy.rule((toy.far, toy.near), (stuck,))
    selection = dc.replace(
        start_selection(rule),
        guidance=stuck,
        aim=Aim.of(toy.X_WT),
        revision=toy.field.revision,
    )
    selection = advance(rule, selection, toy)
    assert names(selection) == ["stuck", "far", "near"]
    assert selection.guidance is toy.near


def until_decided(rule, toy) -> Selection:
    """The selection right after its first round."""
    selection = start_selection(rule)
    while not selection.latest:
        selection = advance(rule, selection, toy, budget=1)
    return selection


def test_hardly_better_does_not_take_over(toy):
    # Both stall, one a few millimetres nearer: worth far less than 0.5 s.
    nearer = dc.replace(toy.far, name="nearer", stopping=0.025)
    selection = until_decided(toy.rule((toy.far, nearer)), toy)
    assert names(selection) == ["far", "nearer"]
    assert selection.guidance is toy.far
    assert selection.reason == "far stalled, none better"
    gain = selection.latest[0].score(0.03) - selection.latest[1].score(0.03)
    assert 0 < gain < 0.5


def test_much_nearer_takes_over_though_it_does_not_arrive(toy):
    # 90 mm more of clearance are 0.9 s of price.
    remote = dc.replace(toy.far, name="remote", stopping=0.120)
    rule = toy.rule((remote, toy.far))
    selection = until_decided(rule, toy)
    assert names(selection) == ["remote", "far"]
    assert selection.guidance is toy.far


def test_a_hopeless_round_is_not_repeated_where_the_robot_stands(toy, counted):
    remote = dc.replace(toy.far, name="remote", stopping=0.120)
    rule = toy.rule((remote, toy.far))
    selection = until_decided(rule, toy)
    counted.clear()
    for time in (0.0, 0.5 * PATIENCE, PATIENCE - 1e-6):
        assert advance(rule, selection, toy, time=time) is selection
    assert not counted
    # It is, once the robot has moved on, and after a while.
    moved = advance(rule, selection, toy, q=toy.q + 0.06, budget=1)
    later = advance(rule, selection, toy, time=PATIENCE, budget=1)
    assert counted == [toy.far] * 2
    for following in (moved, later):
        assert [r.guidance for r in following.running] == [toy.far]


def test_a_new_target_starts_afresh(toy):
    rule = toy.rule((toy.far, toy.near))
    selection = advance(rule, start_selection(rule), toy)
    higher = toy.X_WT.copy()
    higher[2, 3] += 0.3
    selection = advance(rule, selection, toy, budget=1, aim=higher)
    assert selection.guidance is toy.far
    assert selection.reason == "new target"
    assert not selection.finished
    assert not selection.latest
    assert [r.num_steps for r in selection.running] == [1]


def test_a_new_map_aborts_the_round_and_keeps_the_guidance(toy):
    rule = toy.rule((toy.far, toy.near))
    selection = advance(rule, start_selection(rule), toy)
    other = copy.copy(toy.field)
    other.revision = "another"
    # Also while it idles.
    selection = advance(rule, selection, toy, budget=1, field=other)
    assert selection.guidance is toy.near
    assert selection.reason == "new map"
    assert selection.revision == "another"
    assert [r.num_steps for r in selection.running] == [1]


@pytest.mark.parametrize(
    ("tiers", "used"),
    [
        # At its target, the arm's least clearance is 15 mm.
        ((0.030, 0.020, 0.010), 0.010),
        ((0.030, 0.016), 0.016),  # It retreats by a millimetre.
        ((0.014, 0.010), 0.014),
        ((0.040, 0.030), 0.030),  # No smaller one is allowed.
    ],
)
@pytest.mark.parametrize("has_line", [False, True])
def test_what_the_robot_does_not_keep_is_not_asked(toy, tiers, used, has_line):
    first = Guidance(stopping=tiers[0])
    rule = dc.replace(toy.rule((first,)), tiers=tiers)
    target = Target(toy.X_WT)
    if has_line:
        target = target.on_line(toy.X_WT, 0.1)
    there = {"q": toy.q_target, "aim": target, "budget": 0}
    selection = advance(rule, start_selection(rule), toy, **there)
    assert selection.guidance.stopping == used
    # The round's other candidates are those of the rest of the tiers.
    assert rule.from_tier(selection.tier).tiers[0] == used
    # A new target elsewhere begins with the largest distance again.
    higher = toy.X_WT.copy()
    higher[2, 3] += 0.3
    free = dc.replace(rule, tiers=(0.014, *tiers[1:]))
    selection = advance(free, selection, toy, aim=higher, budget=0, q=toy.q)
    assert selection.tier == 0


def test_a_rollout_that_the_robot_refutes_is_not_believed(toy):
    law = toy.law
    planner = MotionPlanner(
        law.robot, law.self_clearance, PlanningConfig(at_once=False)
    )
    rule = dc.replace(toy.rule((toy.near,)), motions=planner)
    first = advance(rule, start_selection(rule), toy)
    assert first.reason == "near arrives"
    # A second later, it has moved, or it stands although it is commanded to
    # move: this says nothing about the rollout.
    for changes in ({"q": toy.q + 0.01}, {"u": np.array([0.1, 0.0, 0.0])}):
        later = advance(rule, first, toy, time=IDLE, **changes)
        assert later.reason == "near arrives"
        assert later.refuted == 0
    later = advance(rule, first, toy, time=IDLE)
    assert later.reason == "near stalled, plan reached"
    assert later.guidance.path is not None
    assert later.refuted == 1
    # If the robot never moves, the searches end, and a new target begins anew.
    for k in range(2, 20):
        later = advance(rule, later, toy, time=k * IDLE)
    assert later.refuted == planner.config.attempts
    higher = toy.X_WT.copy()
    higher[2, 3] += 0.1
    assert advance(rule, later, toy, aim=higher, budget=0).refuted == 0


@pytest.mark.parametrize("name", ["q", "aim"])
def test_a_lost_measurement_changes_nothing(toy, counted, name):
    rule = toy.rule((toy.far, toy.near))
    selection = advance(rule, start_selection(rule), toy, budget=3)
    lost = np.full_like({"q": toy.q, "aim": toy.X_WT}[name], np.nan)
    assert advance(rule, selection, toy, **{name: lost}) is selection
    assert len(counted) == 3


def test_equal_inputs_give_equal_choices(toy):
    rule = toy.rule((toy.far, toy.near))
    one, two = (advance(rule, start_selection(rule), toy) for _ in range(2))
    assert one.guidance is two.guidance
    for a, b in zip(one.latest, two.latest, strict=True):
        np.testing.assert_array_equal(a.path, b.path)


def test_crossing_a_port_copies_nothing(toy):
    selection = start_selection(toy.rule((toy.near,)))
    assert copy.deepcopy(selection) is selection
