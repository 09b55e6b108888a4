"""Selects guidance: the algorithm of the selector, as a pure function.

A round begins with a simulation of the present guidance from the present state.
If the simulated robot reaches the target, the guidance is kept, and nothing is
computed for some time. If it does not, the other candidates are simulated, a
few steps in each tick, while the robot continues to move. The candidates with
the same stopping distance form a tier, and are simulated in parallel. If none
of them reaches the target, the next tier follows. The candidate with the lowest
score replaces the present guidance if its score is lower by a margin.
"""

import dataclasses as dc
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from remosplat_drake.controller.guidance.futures import (
    Futures,
    advance_together,
    are_open,
)
from remosplat_drake.controller.guidance.present_state import PresentState
from remosplat_drake.controller.guidance.rollout import (
    REACHED,
    STALLED,
    Rollout,
    advance_rollout,
)
from remosplat_drake.controller.guidance.selection import (
    Selection,
    on_the_same_world,
)
from remosplat_drake.controller.guidance.selection_rule import SelectionRule
from remosplat_drake.controller.guidance.standing_movers import (
    gone_mover,
    standing,
)
from remosplat_drake.controller.planning.roadmap import NO_ROADMAP
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.tick.tick_calls import asks_python
from remosplat_drake.robot.payload import Payload
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.motion import Motion
from remosplat_drake.signals.target import Target

IDLE = 1.0
"""Time after which a guidance whose rollout reached the target is simulated
again [s]."""

IDLE_AMONG_MOVERS = 0.3
"""Time after which a guidance whose rollout reached the target is simulated
again if there are movers, since their motion may change [s]."""

PATIENCE = 1.0
"""Pause after a round in which no candidate reached the target [s]. It ends
early if the robot moves. From the same configuration, another round would have
the same result."""

_MOVED = 0.05
"""Another round starts if a configuration variable has changed by more than
this value [m, rad]."""

_STOOD, _SHORT = 2e-3, 0.5
"""A robot has stood still if no configuration variable has changed by more than
the first number [m, rad], and no command exceeds it [m/s, rad/s]. Rollouts of
less than the second number [s] are not compared with the robot, which may be
arriving."""

_MARGIN = 0.5
"""The guidance changes only if the score decreases by at least this value
[s]."""

_NEARBY, _LEVER = 0.1, 0.3
"""Two numbers. If a target is given and its pose error is at most the first
number [m], no path is searched at once. The second number is the weight of the
angle in this error [m/rad]."""


def advance_selection(
    rule: SelectionRule,
    selection: Selection,
    *,
    time: float,
    q: np.ndarray,
    u: np.ndarray,
    aim: Aim | Target | np.ndarray,
    field: DistanceField,
    budget: int,
    movers: Movers | None = None,
    motion: Motion | None = None,
    payload: Payload | None = None,
    interrupted: Callable[[], bool] = lambda: False,
    threads: int = 1,
) -> Selection:
    """Advances rollouts by up to `budget` steps, and selects a guidance.

    A new target or a new map starts a new round, with the largest stopping
    distance that the robot then keeps. The candidates of a tier (a stopping
    distance) start from the robot's state at the time at which the tier begins.
    So a round that takes several ticks may have another result than a round
    that ends in one tick because of a larger budget.

    If a path is searched as soon as a target is given, the update exceeds the
    budget until its first candidates have ended. Otherwise, the robot might
    start in a direction that it soon abandons, which takes more time.

    The motion of movers does not end a round: rollouts predict this motion, and
    are repeated more often. A path avoids standing movers. As soon as a
    standing mover has left, the direct way is simulated again.

    Args:
        rule: The selector's settings, such as the planner of candidates and the
            condition of arrival.
        selection: The selection so far.
        time: Present time [s].
        q: Measured configuration, shape (n_q,) [rad, m].
        u: Command that is being executed, shape (n_u,).
        aim: The targets of the end effectors, as an `Aim`. A `Target` or a pose
            X_WT of shape (4, 4) is also accepted; it is the target of the first
            end effector.
        field: The map.
        budget: At most this many rollout steps are simulated.
        movers: The movers; None if none are known.
        motion: Predicted motion that is caused by commands sent so far; None
            for a robot without delay.
        payload: The payload; None if the robot carries nothing.
        interrupted: Function that returns whether to abort a search for a path.
            A search may take long.
        threads: Number of rollouts that may be simulated in parallel. This
            number does not change the result.

    Returns:
        The selection after these steps. It is the same object if no step was
        simulated, or if q or the aim is not finite.
    """
    rule, aim = rule.holding(payload), Aim.of(aim)
    if not (np.isfinite(q).all() and aim.is_known):
        return selection
    before = selection
    selection = on_the_same_world(rule, selection, q, field, aim)
    if aim.has_line:
        return selection  # A line is always followed directly.
    rule = rule.from_tier(selection.tier)
    if selection is not before:
        still = rule.still_open(selection.guidance, q, field)
        selection = dc.replace(selection, guidance=still)
    now = PresentState(time, q, u, aim, movers, motion)
    gone = gone_mover(selection.around, now)
    if gone:
        selection = _way_is_free(rule, selection, now, gone)
    left = budget
    if _is_due(rule, selection, before, now):
        selection = _with_path(rule, selection, now, field, interrupted)
        left = sys.maxsize
    while left > 0:
        if not selection.running:
            if time < selection.idle_until and not _has_moved(selection, q):
                break
            first = _begin((selection.guidance,), now)
            selection = dc.replace(selection, running=first, plans=())
        running, spent = advance_together(
            selection.running,
            lambda rollout, steps: advance_rollout(
                rule.law,
                rollout,
                field,
                aim,
                rule.arrived,
                rule.horizon_of(rollout.guidance),
                steps,
            ),
            rule.tiers[0],
            left,
            1 if asks_python(rule.law, field) else threads,
        )
        left -= spent
        if are_open(running):
            selection = dc.replace(selection, running=running)
        else:
            selection = _file(rule, selection, running, now, field, interrupted)
            left = min(left, budget)
    return selection


def _begin(guidances: tuple[Guidance, ...], now: PresentState) -> Futures:
    return tuple(
        Rollout(
            guidance,
            now.q,
            now.u,
            movers=now.movers,
            start=now.time,
            motion=None if now.motion is None else now.motion.arrays,
        )
        for guidance in guidances
    )


def _is_due(
    rule: SelectionRule,
    selection: Selection,
    before: Selection,
    now: PresentState,
) -> bool:
    """Whether to search a path now, in addition to the direct candidate.

    A path is searched at the first update at which the target has not moved
    since the previous update, since a path to a moving target would soon be
    useless. No path is searched to a near target.
    """
    motions = rule.motions
    if motions is None or not motions.config.at_once:
        return False
    is_first = selection is before and not selection.latest
    if not is_first or selection.plans or selection.guidance.path is not None:
        return False
    errors = now.aim.errors(rule.law.robot.state(now.q).X_WEs)
    return any(e.distance + _LEVER * e.angle > _NEARBY for e in errors)


def _with_path(
    rule: SelectionRule,
    selection: Selection,
    now: PresentState,
    field: DistanceField,
    interrupted: Callable[[], bool],
) -> Selection:
    """Restarts the round with a path and the candidates of the first tier."""
    selection, path = _planned(rule, selection, now, field, interrupted, 1)
    first = rule.candidates(now.q, now.aim, field)[:1]
    others, _ = _next_group(first, selection.guidance)
    group = selection.guidance, *others, *path
    return dc.replace(selection, running=_begin(group, now))


def _way_is_free(
    rule: SelectionRule, selection: Selection, now: PresentState, gone: str
) -> Selection:
    """Begins a round with the initial candidates, without earlier results.

    During the round, the robot follows the present guidance. This guidance is
    simulated later, if no initial candidate reaches the target.
    """
    return Selection(
        selection.guidance,
        f"{gone} has gone",
        running=_begin((rule.start,), now),
        effort=selection.effort,
        found=selection.found,
        roadmap=selection.roadmap,
        revision=selection.revision,
        aim=selection.aim,
        tier=selection.tier,
    )


def _file(
    rule: SelectionRule,
    selection: Selection,
    ended: Futures,
    now: PresentState,
    field: DistanceField,
    interrupted: Callable[[], bool],
) -> Selection:
    """Stores ended rollouts, then begins the next group or selects guidance."""
    if _is_refuted(rule, selection, ended, now):
        ended = (ended[0].ended(STALLED),)
        selection = dc.replace(selection, refuted=selection.refuted + 1)
    incumbent = (selection.finished or ended)[0]
    finished = (*selection.finished, *ended)
    arrives = any(r.status == REACHED for r in ended)
    if arrives and ended == (incumbent,):
        return _end_round(
            selection,
            incumbent.guidance,
            finished,
            f"{incumbent.guidance.name} arrives",
            now.time + _trusted_for(now.movers),
            arriving_at=now.q,
        )
    if arrives:
        return _decide(rule, selection, finished, now)
    waiting = selection.waiting
    if ended[0] is incumbent:
        candidates = rule.candidates(now.q, now.aim, field)
        # The first tier has already been tried, together with the path.
        waiting = (selection.guidance,), *candidates[bool(selection.plans) :]
    group, waiting = _next_group(waiting, incumbent.guidance)
    if not group:
        selection, group = _planned(rule, selection, now, field, interrupted)
    if not group:
        return _decide(rule, selection, finished, now)
    return dc.replace(
        selection,
        running=_begin(group, now),
        waiting=waiting,
        finished=finished,
    )


def _is_refuted(
    rule: SelectionRule,
    selection: Selection,
    ended: Futures,
    now: PresentState,
) -> bool:
    """Whether the robot stands still although its guidance's rollout arrives.

    A rollout takes longer steps than the robot. So it may pass where the robot
    stops: along an obstacle at the stopping distance, towards which the motion
    is curved. The robot may then have stood still since the last rollout that
    arrived. Among movers, a robot may wait.
    """
    there, motions = selection.arriving_at, rule.motions
    if there is None or motions is None or selection.finished:
        return False
    is_alone = len(ended) == 1 and ended[0].status == REACHED
    has_movers = now.movers is not None and len(now.movers)
    if not is_alone or has_movers or ended[0].time < _SHORT:
        return False
    moved = max(np.abs(now.q - there).max(), np.abs(now.u).max())
    return bool(moved <= _STOOD and selection.refuted < motions.config.attempts)


def _next_group(
    waiting: tuple[tuple[Guidance, ...], ...], tried: Guidance
) -> tuple[tuple[Guidance, ...], tuple[tuple[Guidance, ...], ...]]:
    """Returns the first group with untried guidance, and all later groups."""
    for i, group in enumerate(waiting):
        others = tuple(guidance for guidance in group if guidance != tried)
        if others:
            return others, waiting[i + 1 :]
    return (), ()


def _planned(
    rule: SelectionRule,
    selection: Selection,
    now: PresentState,
    field: DistanceField,
    interrupted: Callable[[], bool],
    tiers: int | None = None,
) -> tuple[Selection, tuple[Guidance, ...]]:
    """Searches a path with one stopping distance after the other.

    `tiers` limits the number of stopping distances that are tried.
    """
    motions, plans = rule.motions, selection.plans
    attempt = selection.failures + selection.refuted
    if motions is None or selection.failures >= motions.config.attempts:
        return selection, ()
    guidance, effort, found = None, selection.effort, selection.found
    around = standing(now)
    # The roadmap is not used if a path to this target was found before, or if a
    # round has failed, since it would probably lead to the same path.
    again = attempt or found
    roadmap = NO_ROADMAP if again else selection.roadmap
    while guidance is None and len(plans) < (tiers or len(rule.tiers)):
        guidance, plan = rule.planned(
            now,
            field,
            len(plans),
            min(attempt, motions.config.attempts - 1),
            interrupted,
            roadmap,
            around,
        )
        plans, effort = (*plans, plan), effort.with_plan(plan)
        if plan.corners is not None:
            found = (*found, plan.corners)
    selection = dc.replace(
        selection, plans=plans, effort=effort, found=found, around=around
    )
    return selection, () if guidance is None else (guidance,)


def _decide(
    rule: SelectionRule,
    selection: Selection,
    finished: tuple[Rollout, ...],
    now: PresentState,
) -> Selection:
    first_tier = rule.tiers[0]
    incumbent = finished[0]
    best = min(finished, key=lambda rollout: rollout.score(first_tier))
    gain = incumbent.score(first_tier) - best.score(first_tier)
    # If a path was found as soon as the target was given, its score needs no
    # margin. Otherwise, the robot would first move directly to the target, and
    # change to the path later.
    margin = _MARGIN if selection.latest or not selection.plans else 0.0
    if best is incumbent or gain <= margin:
        best = incumbent
        reason = f"{incumbent.guidance.name} {incumbent.status}, none better"
    else:
        reason = (
            f"{incumbent.guidance.name} {incumbent.status},"
            f" {best.guidance.name} {best.status}"
        )
    arrives = best.status == REACHED
    return _end_round(
        selection,
        best.guidance,
        finished,
        reason,
        now.time + (_trusted_for(now.movers) if arrives else PATIENCE),
        **{"arriving_at" if arrives else "hopeless_at": now.q},
    )


def _end_round(
    selection: Selection,
    guidance: Guidance,
    finished: tuple[Rollout, ...],
    reason: str,
    idle_until: float,
    *,
    hopeless_at: np.ndarray | None = None,
    arriving_at: np.ndarray | None = None,
) -> Selection:
    return Selection(
        guidance=guidance,
        reason=reason,
        latest=finished,
        idle_until=idle_until,
        hopeless_at=hopeless_at,
        arriving_at=arriving_at,
        refuted=selection.refuted,
        **_searched(selection, arrives=hopeless_at is None),
        effort=selection.effort,
        found=selection.found,
        roadmap=selection.roadmap,
        around=selection.around,
        revision=selection.revision,
        aim=selection.aim,
        tier=selection.tier,
    )


def _trusted_for(movers: Movers | None) -> float:
    """Returns the time until a successful guidance is simulated again [s]."""
    return IDLE if movers is None or not len(movers) else IDLE_AMONG_MOVERS


def _searched(selection: Selection, *, arrives: bool) -> dict[str, Any]:
    """Returns the results of a round's searches, as fields of `Selection`."""
    plans = selection.plans
    if arrives:
        return {"plans": plans}
    failed = next((plan for plan in plans[::-1] if plan.lack), None)
    why, lack = selection.unreachable, selection.lack
    if failed is not None:
        why, lack = failed.reason, failed.lack
    if failed is not None and len(selection.around):
        names = " and ".join(dict.fromkeys(m.name for m in selection.around))
        why = f"{names} in the way: {why}"
    return {
        "plans": plans,
        "failures": selection.failures + bool(plans),
        "unreachable": why,
        "lack": lack,
    }


def _has_moved(selection: Selection, q: np.ndarray) -> bool:
    """Whether the robot has moved since a round that had no arrival."""
    there = selection.hopeless_at
    return there is not None and bool(np.abs(q - there).max() > _MOVED)
