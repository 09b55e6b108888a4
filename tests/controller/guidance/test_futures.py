"""Rollouts side by side: shares of the budget, ends, and threads.

The rollouts are the real ones of the toy world; how many threads simulate
them, and in which slices, must not be seen in what comes out.
"""

import dataclasses as dc
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from patience import PATIENCE

from remosplat_drake.controller.guidance.futures import (
    advance_together,
    are_open,
)
from remosplat_drake.controller.guidance.guidance import Guidance
from remosplat_drake.controller.guidance.rollout import (
    OUTRUN,
    REACHED,
    RUNNING,
    STALLED,
    Rollout,
    advance_rollout,
)

FIRST_TIER = 0.030


def begun(toy, *guidances: Guidance) -> tuple[Rollout, ...]:
    return tuple(Rollout(g, toy.q, np.zeros(3)) for g in guidances)


def advancing(toy):
    rule = toy.rule()

    def advance(rollout: Rollout, steps: int) -> Rollout:
        return advance_rollout(
            rule.law, rollout, toy.field, toy.X_WT, rule.arrived, 4.0, steps
        )

    return advance


def to_the_end(toy, futures, budget=10_000, threads=1):
    spent = 0
    while are_open(futures):
        futures, more = advance_together(
            futures, advancing(toy), FIRST_TIER, budget, threads
        )
        assert 1 <= more <= budget
        spent += more
    return futures, spent


def counting(rollout: Rollout, steps: int) -> Rollout:
    """Steps of a world in which nothing happens."""
    return dc.replace(rollout, path=(*rollout.path, *np.zeros((steps, 3))))


def test_shares_are_even_and_the_rest_goes_to_who_is_behind(toy):
    futures = begun(toy, toy.far, toy.near, toy.far)
    for budget, steps in [(7, [3, 2, 2]), (1, [3, 3, 2]), (4, [4, 4, 4])]:
        futures, spent = advance_together(futures, counting, 0.0, budget, 1)
        assert spent == budget
        assert [r.num_steps for r in futures] == steps


def test_who_has_ended_takes_no_share(toy):
    one, two, three = begun(toy, toy.far, toy.near, toy.far)
    futures = one, two.ended(STALLED), three
    futures, spent = advance_together(futures, counting, 0.0, 6, 1)
    assert spent == 6
    assert [r.num_steps for r in futures] == [3, 0, 3]
    assert futures[1].status == STALLED


def test_what_an_end_leaves_of_a_share_is_not_spent(toy):
    futures = begun(toy, toy.near, toy.far)
    ended, spent = to_the_end(toy, futures)
    assert spent == sum(r.num_steps for r in ended) < 200
    assert [r.status for r in ended] == [REACHED, STALLED]


def test_who_cannot_win_any_more_is_outrun(toy):
    """Two equal futures, but that one begins farther away."""
    (near,) = begun(toy, toy.near)
    futures = dc.replace(near, q=toy.q - 0.2), near
    slow, fast = to_the_end(toy, futures, budget=2)[0]
    assert (slow.status, fast.status) == (OUTRUN, REACHED)
    assert slow.score(FIRST_TIER) == np.inf
    assert slow.time == pytest.approx(fast.time)
    # With as much of the budget as it takes, it arrives, and is not better.
    slow, fast = to_the_end(toy, futures)[0]
    assert slow.status == fast.status == REACHED
    assert slow.score(FIRST_TIER) > fast.score(FIRST_TIER)


def test_who_keeps_a_larger_distance_may_still_be_cheaper(toy):
    """7 mm of stopping distance are worth almost three seconds."""
    wide = dc.replace(toy.near, name="wide", stopping=0.012)
    slow, near = begun(toy, wide, toy.near)
    slow = dc.replace(slow, q=toy.q - 0.2)
    slow, near = to_the_end(toy, (slow, near), budget=2)[0]
    assert slow.status == near.status == REACHED
    assert slow.time > near.time
    assert slow.score(FIRST_TIER) < near.score(FIRST_TIER)


@settings(max_examples=15)
@given(
    budget=st.integers(1, 40),
    threads=st.integers(1, 4),
    stoppings=st.lists(
        st.sampled_from([0.001, 0.005, 0.01, 0.02, 0.03, 0.1]),
        min_size=1,
        max_size=4,
    ),
)
def test_threads_are_not_seen(toy, budget, threads, stoppings):
    guidances = [Guidance(f"{i}", stopping=s) for i, s in enumerate(stoppings)]
    futures = begun(toy, *guidances)
    one, taken = to_the_end(toy, futures, budget)
    other, taken_by_threads = to_the_end(toy, futures, budget, threads)
    assert taken == taken_by_threads
    for a, b in zip(one, other, strict=True):
        assert (a.guidance, a.status, a.time) == (b.guidance, b.status, b.time)
        np.testing.assert_array_equal(a.path, b.path)
        np.testing.assert_array_equal(a.q, b.q)


def test_threads_simulate_at_the_same_time(toy):
    """Each waits until all three are simulated."""
    together = threading.Barrier(3, timeout=PATIENCE)

    def advance(rollout: Rollout, steps: int) -> Rollout:
        together.wait()
        return counting(rollout, steps)

    futures = begun(toy, toy.far, toy.near, toy.far)
    futures, spent = advance_together(futures, advance, 0.0, 6, 3)
    assert spent == 6
    assert all(r.status == RUNNING for r in futures)


def test_what_fails_in_a_thread_is_raised(toy):
    def advance(rollout: Rollout, steps: int) -> Rollout:
        if rollout.guidance is toy.near:
            raise ValueError("near has failed")
        return counting(rollout, steps)

    futures = begun(toy, toy.far, toy.near)
    with pytest.raises(ValueError, match="near has failed"):
        advance_together(futures, advance, 0.0, 2, 2)
