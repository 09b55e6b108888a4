"""Workers take few jobs, since what these leave behind stays with them."""

import os
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from remosplat_drake.base import pool
from remosplat_drake.base.pool import DIED, Job, run_jobs
from tests.patience import wait_for


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


def sleep_long(path: str) -> str:
    Path(path).write_text(str(os.getpid()))
    signal.pause()
    return path


def test_workers_end_when_their_parent_is_killed(tmp_path):
    """Otherwise a worker would compute on, at full speed, without a use."""
    told = tmp_path / "worker"
    program = (
        "from remosplat_drake.base.pool import Job, run_jobs\n"
        "from tests.base.test_pool import failed, sleep_long\n"
        "if __name__ == '__main__':\n"
        f"    list(run_jobs([Job({str(told)!r}, sleep_long, failed)], 1))\n"
    )
    script = tmp_path / "program.py"
    script.write_text(program)
    root = Path(__file__).parents[2]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    parent = subprocess.Popen([sys.executable, str(script)], env=environment)
    wait_for(lambda: told.exists() and bool(told.read_text()))
    worker = int(told.read_text())
    assert is_alive(worker)
    parent.kill()
    parent.wait()
    wait_for(lambda: not is_alive(worker))


def is_alive(pid: int) -> bool:
    """Returns whether a process runs; a zombie does not."""
    try:
        return "State:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except FileNotFoundError:
        return False
