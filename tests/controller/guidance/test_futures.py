"""Rollouts side by side: shares of the budget, ends, and threads.

The rollouts are the real ones of the toy world; how many threads simulate
them, and in which slices, must not be seen in what comes out.
"""

import dataclasses as dc
import os
import signal
import threading
import time

import numpy as np
import pytest
from asked_in_python import AskedInPython
from hypothesis import given, settings
from hypothesis import strategies as st
from patience import PATIENCE

from remosplat_drake.controller.guidance import selection_round
from remosplat_drake.controller.guidance.futures import (
    advance_together,
    are_open,
)
from remosplat_drake.controller.guidance.present_state import PresentState
from remosplat_drake.controller.guidance.rollout import (
    OUTRUN,
    REACHED,
    RUNNING,
    STALLED,
    STRIDE,
    Rollout,
    advance_rollout,
)
from remosplat_drake.controller.guidance.selection import start_selection
from remosplat_drake.controller.guidance.selection_round import (
    advance_selection,
)
from remosplat_drake.controller.guidance.worker import look_ahead
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.tick.tick_calls import asks_python
from remosplat_drake.signals.aim import Aim

FIRST_TIER = 0.030


def begun(toy, *guidances: Guidance) -> tuple[Rollout, ...]:
    return tuple(Rollout(g, toy.q, np.zeros(3)) for g in guidances)


def advancing(toy, solver):
    law, arrived = toy.law.with_step(0.1, solver=solver), toy.rule().arrived

    def advance(rollout: Rollout, steps: int) -> Rollout:
        return advance_rollout(
            law, rollout, toy.field, toy.X_WT, arrived, 4.0, steps
        )

    return advance


def to_the_end(toy, futures, budget=10_000, threads=1, solver="active_set"):
    spent = 0
    while are_open(futures):
        futures, more = advance_together(
            futures, advancing(toy, solver), FIRST_TIER, budget, threads
        )
        assert 1 <= more <= budget
        spent += more
    return futures, spent


def counting(rollout: Rollout, steps: int) -> Rollout:
    """Steps of a world in which nothing happens."""
    return dc.replace(rollout, path=(*rollout.path, *np.zeros((steps, 3))))


def test_strides_go_to_who_is_behind(toy):
    futures = begun(toy, toy.far, toy.near, toy.far)
    for budget, steps in [(7, [5, 2, 0]), (5, [5, 2, 5]), (4, [5, 6, 5])]:
        futures, spent = advance_together(futures, counting, 0.0, budget, 1)
        assert spent == budget
        assert [r.num_steps for r in futures] == steps
    # A stride each, with any budget left.
    futures, spent = advance_together(futures, counting, 0.0, 100, 1)
    assert spent == 3 * STRIDE
    assert [r.num_steps for r in futures] == [10, 11, 10]


def test_who_has_ended_takes_no_stride(toy):
    one, two, three = begun(toy, toy.far, toy.near, toy.far)
    futures = one, two.ended(STALLED), three
    futures, spent = advance_together(futures, counting, 0.0, 6, 1)
    assert spent == 6
    assert [r.num_steps for r in futures] == [5, 0, 1]
    assert futures[1].status == STALLED


def test_what_an_end_leaves_of_a_share_is_not_spent(toy):
    futures = begun(toy, toy.near, toy.far)
    ended, spent = to_the_end(toy, futures)
    assert spent == sum(r.num_steps for r in ended) < 200
    assert [r.status for r in ended] == [REACHED, STALLED]


@pytest.mark.parametrize("budget", [1, 7, 10_000])
def test_who_cannot_win_any_more_is_outrun(toy, budget):
    """Two equal futures, but that one begins farther away."""
    (near,) = begun(toy, toy.near)
    futures = dc.replace(near, q=toy.q - 0.2), near
    slow, fast = to_the_end(toy, futures, budget)[0]
    assert (slow.status, fast.status) == (OUTRUN, REACHED)
    assert slow.score(FIRST_TIER) == np.inf
    assert fast.time <= slow.time + 1e-9
    assert slow.num_steps < fast.num_steps + STRIDE + 1
    (alone,), _ = to_the_end(toy, futures[:1])
    assert alone.status == REACHED
    assert alone.score(FIRST_TIER) > fast.score(FIRST_TIER)


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
    threads=st.integers(2, 4),
    stoppings=st.lists(
        st.sampled_from([0.001, 0.005, 0.01, 0.02, 0.03, 0.1]),
        min_size=1,
        max_size=4,
    ),
)
@pytest.mark.parametrize("solver", ["active_set", "clarabel"])
def test_threads_are_not_seen(toy, solver, budget, threads, stoppings):
    """Neither where kernels simulate, nor where Python does."""
    guidances = [Guidance(f"{i}", stopping=s) for i, s in enumerate(stoppings)]
    futures = begun(toy, *guidances)
    one, taken = to_the_end(toy, futures, budget, 1, solver)
    other, taken_too = to_the_end(toy, futures, budget, threads, solver)
    assert taken == taken_too
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
    futures, spent = advance_together(futures, advance, 0.0, 15, 3)
    assert spent == 15
    assert all(r.status == RUNNING for r in futures)


@pytest.mark.parametrize("failing", [0, 2])
def test_what_fails_in_a_thread_is_raised_when_all_are_done(toy, failing):
    futures = begun(toy, toy.far, toy.near, toy.far)
    done = []

    def advance(rollout: Rollout, steps: int) -> Rollout:
        if rollout is futures[failing]:
            raise ValueError(f"rollout {failing} has failed")
        time.sleep(0.01)
        done.append(rollout)
        return counting(rollout, steps)

    with pytest.raises(ValueError, match=f"rollout {failing} has failed"):
        advance_together(futures, advance, 0.0, 15, 2)
    assert len(done) == 2


def test_a_forked_child_simulates_too(toy):
    advance_together(begun(toy, toy.far, toy.near), counting, 0.0, 10, 2)
    child = os.fork()
    if not child:
        futures = begun(toy, toy.far, toy.near)
        spent = advance_together(futures, counting, 0.0, 10, 2)[1]
        os._exit(spent)
    end = time.monotonic() + PATIENCE
    ended, status = os.waitpid(child, os.WNOHANG)
    while not ended and time.monotonic() < end:
        time.sleep(0.005)
        ended, status = os.waitpid(child, os.WNOHANG)
    if not ended:
        os.kill(child, signal.SIGKILL)
    assert os.waitstatus_to_exitcode(status) == 10


def test_a_round_is_the_same_with_threads(toy):
    law = toy.law.with_step(0.1, solver="active_set")
    far, near = toy.far, toy.near
    aside = dc.replace(far, name="aside", side=1.0)
    rule = dc.replace(toy.rule((far, aside), (near, far)), law=law)
    assert not asks_python(law, toy.field)
    rounds = []
    for threads in (1, 3):
        selection = start_selection(rule)
        while not selection.latest:
            selection = advance_selection(
                rule,
                selection,
                time=0.0,
                q=toy.q,
                u=np.zeros(3),
                aim=toy.X_WT,
                field=toy.field,
                budget=7,
                threads=threads,
            )
        assert selection.guidance is near
        rounds.append(selection)
    for a, b in zip(*(r.latest for r in rounds), strict=True):
        assert (a.guidance, a.status) == (b.guidance, b.status)
        np.testing.assert_array_equal(a.path, b.path)


@pytest.mark.parametrize(
    ("solver", "outside", "alone"),
    [
        ("active_set", False, False),
        ("active_set", True, True),
        ("clarabel", False, False),
    ],
)
def test_what_python_simulates_keeps_to_one_thread(
    toy, monkeypatch, solver, outside, alone
):
    """Other people's maps and ingredients need not bear several."""
    law = toy.law.with_step(0.1, solver=solver)
    rule = dc.replace(toy.rule((toy.far,), (toy.near, toy.far)), law=law)
    field = AskedInPython(toy.field) if outside else toy.field
    threads_used = set()
    advance = selection_round.advance_rollout

    def noting(*arguments):
        threads_used.add(threading.current_thread())
        return advance(*arguments)

    monkeypatch.setattr(selection_round, "advance_rollout", noting)
    now = PresentState(0.0, toy.q, np.zeros(3), Aim.of(toy.X_WT), None)
    aside = dc.replace(toy.far, name="aside", side=1.0)
    both = begun(toy, toy.near, aside)
    selection = dc.replace(
        start_selection(rule),
        running=both,
        finished=begun(toy, toy.far),
        revision=field.revision,
        aim=now.aim,
    )
    selection = look_ahead(
        rule,
        selection,
        now,
        field,
        time.perf_counter() + PATIENCE,
        lambda: bool(threads_used),
        threads=3,
    )
    assert (threads_used == {threading.current_thread()}) == alone
    steps = [r.num_steps for r in selection.running]
    assert steps == ([1, 0] if alone else [STRIDE, STRIDE])
