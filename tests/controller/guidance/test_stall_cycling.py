"""Guidance without look-ahead: order and timing, on paper."""

import numpy as np
import pytest

from remosplat_drake.controller.guidance.selection import start_selection
from remosplat_drake.controller.guidance.stall_cycling import (
    STALL_SPEED,
    cycle_when_stalled,
)
from remosplat_drake.controller.program.guidance import make_candidates

PERIOD = 0.05
FIRST, SECOND = make_candidates([0.021, 0.010])


def run(toy, rule, *, ticks, u=(0.0, 0.0, 0.0), selection=None, **changes):
    """Selections of an arm that executes u, and the last of them."""
    selection = selection or start_selection(rule)
    arguments = {"q": toy.q, "aim": toy.X_WT, "field": toy.field, **changes}
    seen = []
    for k in ticks:
        selection = cycle_when_stalled(
            rule, selection, time=PERIOD * k, u=np.array(u), **arguments
        )
        seen.append((selection.guidance.name, selection.guidance.stopping))
    return seen, selection


@pytest.fixture
def rule(toy):
    return toy.rule(FIRST, SECOND)


def test_a_standing_arm_tries_one_after_the_other(toy, rule):
    seen, selection = run(toy, rule, ticks=range(60))
    order = list(dict.fromkeys(seen))
    assert order == [
        (g.name, g.stopping) for tier in (FIRST, SECOND) for g in tier
    ]
    # 0.2 s of patience first, 0.4 s with every candidate after that.
    changes = [k for k in range(1, 60) if seen[k] != seen[k - 1]]
    assert changes == [4, 12, 20, 28, 36, 44, 52]
    # After the last candidate comes the first.
    assert seen[44] == seen[0]
    assert selection.reason.endswith("stalled")


def test_a_moving_hand_is_left_alone(toy, rule, three_link):
    Jv = three_link.state(toy.q).Jv_WE
    u = np.array([1.0, 0.0, 0.0])
    u *= 1.01 * STALL_SPEED / np.linalg.norm(Jv @ u)
    seen, _ = run(toy, rule, ticks=range(40), u=u)
    assert set(seen) == {("direct", 0.021)}
    seen, _ = run(toy, rule, ticks=range(40), u=0.98 * u)
    assert len(set(seen)) > 1


def test_a_short_halt_is_no_stall(toy, rule):
    u = [1.0, 0.0, 0.0]
    _, selection = run(toy, rule, ticks=range(3), u=u)
    _, selection = run(toy, rule, ticks=range(3, 6), selection=selection)
    _, selection = run(toy, rule, ticks=[6], u=u, selection=selection)
    seen, _ = run(toy, rule, ticks=range(7, 10), selection=selection)
    assert set(seen) == {("direct", 0.021)}


def test_who_has_arrived_may_rest(toy, rule):
    seen, _ = run(toy, rule, ticks=range(40), q=toy.q_target)
    assert set(seen) == {("direct", 0.021)}


def test_a_new_target_starts_afresh_with_new_patience(toy, rule):
    _, selection = run(toy, rule, ticks=range(10))
    assert selection.guidance.name == "left"
    higher = toy.X_WT.copy()
    higher[2, 3] += 0.3
    seen, _ = run(
        toy, rule, ticks=range(10, 15), selection=selection, aim=higher
    )
    assert seen[:4] == [("direct", 0.021)] * 4
    assert seen[4] == ("left", 0.021)


@pytest.mark.parametrize("name", ["q", "aim"])
def test_a_lost_measurement_changes_nothing(toy, rule, name):
    lost = np.full_like({"q": toy.q, "aim": toy.X_WT}[name], np.nan)
    seen, _ = run(toy, rule, ticks=range(40), **{name: lost})
    assert set(seen) == {("direct", 0.021)}
