"""The runner: repeatable, resumable, and not stopped by a bad trial."""

import dataclasses as dc
import os
import signal
from pathlib import Path

import pytest

from remosplat_drake.base.errors import FileError
from remosplat_drake.benchmark.result import CRASH, read_results, to_line
from remosplat_drake.benchmark.runner import run_trials
from remosplat_drake.benchmark.trial import Trial, describe


def instant(trial: Trial):
    return describe(trial)


def fails_in_scene_1(trial: Trial):
    if trial.case.seed == 1:
        raise ValueError("no such luck")
    return describe(trial)


def kills_its_worker_in_scene_1(trial: Trial):
    if trial.case.seed == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return describe(trial)


def kills_its_worker_once(trial: Trial):
    flag = Path(os.environ["REMOSPLAT_TEST_FLAG"])
    if not flag.exists():
        flag.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return describe(trial)


def must_not_run(trial: Trial):
    raise AssertionError("it is in the file already")


def test_parallel_runs_give_what_a_serial_one_gives(tmp_path, trials):
    serial = run_trials(trials, tmp_path / "a.jsonl", jobs=0)
    backwards = run_trials(trials[::-1], tmp_path / "b.jsonl", jobs=2)
    assert [r.repeatable() for r in serial] == [
        r.repeatable() for r in backwards[::-1]
    ]
    assert not any(r.error for r in serial)
    assert all(r.text.duration == pytest.approx(0.4) for r in serial)
    assert {r.statuses["optimal"] for r in serial} == {8}


def test_what_is_in_the_file_is_not_run_again(tmp_path, trials):
    path, counts = tmp_path / "trials.jsonl", []
    first = run_trials(trials[:1], path, jobs=0, function=instant)
    both = run_trials(
        trials,
        path,
        jobs=0,
        on_start=counts.append,
        function=instant,
    )
    assert counts == [1]
    assert both[0] == first[0]
    assert run_trials(trials, path, jobs=0, function=must_not_run) == both
    # Another time limit is another trial.
    method = trials[0].method
    scenario = dc.replace(method.scenario, time_limit=0.3)
    other = dc.replace(trials[0], method=dc.replace(method, scenario=scenario))
    run_trials([other], path, jobs=0, function=instant)
    assert len(read_results(path)) == 3


@pytest.mark.parametrize("jobs", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_a_crash_is_recorded_and_tried_again(tmp_path, trials, jobs):
    path = tmp_path / "trials.jsonl"
    bad, good = run_trials(trials, path, jobs=jobs, function=fails_in_scene_1)
    assert bad.outcome("text") == CRASH
    assert bad.error.endswith("ValueError: no such luck")
    assert not good.error
    again = run_trials(trials, path, jobs=0, function=instant)
    assert not any(r.error for r in again)
    assert read_results(path) == again


@pytest.mark.slow
def test_a_dying_worker_costs_only_its_own_trial(tmp_path, trials):
    path = tmp_path / "trials.jsonl"
    bad, good = run_trials(
        trials, path, jobs=2, function=kills_its_worker_in_scene_1
    )
    assert bad.error == "its process died"
    assert not good.error
    assert len(read_results(path)) == 2


@pytest.mark.slow
def test_a_worker_that_is_killed_loses_nothing(tmp_path, trials, monkeypatch):
    monkeypatch.setenv("REMOSPLAT_TEST_FLAG", str(tmp_path / "flag"))
    results = run_trials(
        trials, tmp_path / "x.jsonl", jobs=2, function=kills_its_worker_once
    )
    assert not any(r.error for r in results)


def test_an_interrupted_run_goes_on_where_it_was(tmp_path, trials):
    path, counts = tmp_path / "trials.jsonl", []

    def interrupt(result):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_trials(trials, path, jobs=0, on_result=interrupt, function=instant)
    assert len(read_results(path)) == 1
    run_trials(
        trials,
        path,
        jobs=0,
        on_start=counts.append,
        function=instant,
    )
    assert counts == [1]
    assert len(read_results(path)) == 2


def test_a_torn_line_is_replaced(tmp_path, trials):
    path = tmp_path / "trials.jsonl"
    path.write_text(to_line(describe(trials[0]))[:50])
    results = run_trials(trials, path, jobs=0, function=instant)
    assert read_results(path) == results


def test_a_folder_in_the_way_is_named(tmp_path, trials):
    with pytest.raises(FileError, match=tmp_path.name):
        run_trials(trials, tmp_path, jobs=0, function=instant)
