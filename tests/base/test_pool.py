"""Workers take few jobs, since what these leave behind stays with them."""

import os
from collections import Counter

import pytest

from remosplat_drake.base import pool
from remosplat_drake.base.pool import DIED, Job, run_jobs


def where(_) -> int:
    return os.getpid()


def name_or_death(subject: str) -> str:
    if subject == "kill":
        os._exit(1)
    return subject


def failed(subject, error: str) -> str:
    return f"{subject}: {error}"


@pytest.mark.parametrize("count", [4, 5])
def test_workers_are_replaced(monkeypatch, count):
    monkeypatch.setattr(pool, "JOBS_A_WORKER", 2)
    jobs = [Job(i, where, failed) for i in range(count)]
    done = Counter(run_jobs(jobs, workers=1))
    assert sorted(done.values(), reverse=True) == [2, 2, 1][: len(done)]
    assert sum(done.values()) == count


def test_a_death_costs_one_job_of_any_batch(monkeypatch):
    monkeypatch.setattr(pool, "JOBS_A_WORKER", 2)
    names = ["a", "b", "c", "kill", "d"]
    jobs = [Job(name, name_or_death, failed) for name in names]
    results = sorted(run_jobs(jobs, workers=1))
    assert results == ["a", "b", "c", "d", f"kill: {DIED}"]
