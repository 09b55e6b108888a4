"""Advances several rollouts in parallel on several threads."""

import math
from collections.abc import Callable
from concurrent.futures import wait

from remosplat_drake.base.threads import kept_threads
from remosplat_drake.controller.guidance.rollout import (
    OUTRUN,
    REACHED,
    RUNNING,
    STRIDE,
    Rollout,
)

Futures = tuple[Rollout, ...]
"""Rollouts that began from the same state, including those that have ended."""


def are_open(futures: Futures) -> bool:
    """Returns whether any of the rollouts has not ended."""
    return any(rollout.status == RUNNING for rollout in futures)


def advance_together(
    futures: Futures,
    advance: Callable[[Rollout, int], Rollout],
    first_tier: float,
    budget: int,
    threads: int,
) -> tuple[Futures, int]:
    """Advances rollouts by some steps, those with the fewest steps first.

    If a rollout has reached the target, every other rollout ends with the
    status `OUTRUN` as soon as its score can no longer be lower.

    Args:
        futures: The rollouts, at least one of which has not ended.
        advance: Function that simulates a number of steps of a rollout, or
            fewer steps if the rollout ends. It is called from several threads.
        first_tier: The usual stopping distance, for the score [m].
        budget: At most this many steps are simulated in total. If it is too
            small, some rollouts advance by fewer steps, or only in the next
            call.
        threads: Number of rollouts that are simulated in parallel. This number
            does not change the results.

    Returns:
        The rollouts in the same order, and the number of simulated steps, which
        is at least one.
    """
    shares = _shares(futures, budget)
    jobs = [(futures[i], share) for i, share in shares.items()]
    advanced = dict(zip(shares, _all_of(jobs, advance, threads), strict=True))
    after = tuple(advanced.get(i, futures[i]) for i in range(len(futures)))
    spent = sum(r.num_steps for r in after) - sum(r.num_steps for r in futures)
    return _without_outrun(after, first_tier), spent


def _shares(futures: Futures, budget: int) -> dict[int, int]:
    """Returns the number of steps by which each rollout advances."""
    running = [i for i, r in enumerate(futures) if r.status == RUNNING]
    shares = {}
    for i in sorted(running, key=lambda i: futures[i].num_steps):
        if budget > 0:
            shares[i] = min(STRIDE, budget)
            budget -= shares[i]
    return shares


def _all_of(
    jobs: list[tuple[Rollout, int]],
    advance: Callable[[Rollout, int], Rollout],
    threads: int,
) -> list[Rollout]:
    if threads < 2 or len(jobs) < 2:
        return [advance(*job) for job in jobs]
    # This thread simulates a part of the rollouts, too.
    pool = kept_threads("rollouts", threads - 1)
    others = [pool.submit(advance, *job) for job in jobs[1:]]
    try:
        return [advance(*jobs[0]), *(other.result() for other in others)]
    finally:
        wait(others)


def _without_outrun(futures: Futures, first_tier: float) -> Futures:
    """Ends rollouts that can no longer have the lowest score."""
    arrived = (r.score(first_tier) for r in futures if r.status == REACHED)
    cheapest = min(arrived, default=math.inf)
    return tuple(
        r.ended(OUTRUN)
        if r.status == RUNNING and r.arrival(first_tier) >= cheapest
        else r
        for r in futures
    )
