"""Trials on a Ray cluster of two nodes, started here."""

import os
import signal
from dataclasses import replace
from pathlib import Path

import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.benchmark.result import read_results
from remosplat_drake.benchmark.runner import run_trials
from remosplat_drake.benchmark.trial import Trial, run_trial

ray = pytest.importorskip("ray", reason="needs the extra `cluster`")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def address():
    """Two nodes of one core each."""
    from ray.cluster_utils import Cluster

    here = str(Path(__file__).parent)
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = here
    cluster = Cluster(
        initialize_head=True,
        head_node_args={"num_cpus": 1, "include_dashboard": False},
    )
    cluster.add_node(num_cpus=1)
    cluster.wait_for_nodes()
    yield cluster.address
    cluster.shutdown()
    if before is None:
        del os.environ["PYTHONPATH"]
    else:
        os.environ["PYTHONPATH"] = before


def kills_its_worker_once(trial: Trial):
    flag = Path(trial.case.splat_folders[0]) / "flag"
    if not flag.exists():
        flag.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return run_trial(trial)


def test_a_cluster_gives_what_a_serial_run_gives(tmp_path, trials, address):
    serial = run_trials(trials, tmp_path / "a.jsonl", jobs=0)
    path = tmp_path / "b.jsonl"
    cluster = run_trials(trials, path, jobs=0, ray_address=address)
    assert [r.repeatable() for r in cluster] == [r.repeatable() for r in serial]
    assert len(read_results(path)) == len(trials)


def test_a_worker_that_is_killed_loses_nothing(tmp_path, trials, address):
    marked = [
        replace(t, case=replace(t.case, splat_folders=(str(tmp_path),)))
        for t in trials
    ]
    results = run_trials(
        marked,
        tmp_path / "x.jsonl",
        jobs=0,
        ray_address=address,
        function=kills_its_worker_once,
    )
    assert (tmp_path / "flag").exists()
    serial = run_trials(trials, tmp_path / "a.jsonl", jobs=0)
    assert [r.repeatable() for r in results] == [r.repeatable() for r in serial]


@pytest.mark.parametrize("nowhere", ["127.0.0.1:1", "127.0.0.1:x"])
def test_a_cluster_that_is_not_there_is_named(tmp_path, trials, nowhere):
    with pytest.raises(RemoSplatError, match=f"no cluster.*'{nowhere}'"):
        run_trials(trials, tmp_path / "x.jsonl", jobs=0, ray_address=nowhere)
