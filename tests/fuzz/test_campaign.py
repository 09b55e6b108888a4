"""A minute of the campaign; and that it notices what it is there for."""

import random
from pathlib import Path

import pytest

from . import campaign
from .formats import FORMATS, interleaved
from .mutations import mutated

SEEDS = 25
"""Of each format in the suite; `python -m tests.fuzz` goes on from there."""

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/clear_refs").exists(),
    reason="memory is measured as Linux's kernel does it",
)


def test_no_file_does_what_none_may():
    cases = [(name, seed) for seed in range(SEEDS) for name in FORMATS]
    outcomes = campaign.run(cases)
    assert [o for o in outcomes if o.failed] == []
    for name, kinds in campaign.counts(outcomes).items():
        if kinds["missing"] == SEEDS:
            continue
        # Not vacuous: good files are read, and most of the others are not.
        assert next(o for o in outcomes if o.format == name).kind == "read"
        assert kinds["refused"] > 0 or name in ("pose-target", "base-status")


@pytest.mark.parametrize(
    ("reader", "kind", "text"),
    [
        ("good", "read", ""),
        ("refuse", "refused", "is no good"),
        ("raise", "traceback", "ValueError at misbehaving.py"),
        ("warn", "traceback", "RuntimeWarning"),
        ("crash", "crash", "exit code -6"),
        ("exit", "crash", "exit code 0"),
        ("spin", "crash", "exit code -24"),  # SIGXCPU: too much of it.
        ("swell", "memory", "95 MiB for 7 bytes"),
        ("swell-beyond", "traceback", "Unable to allocate"),
    ],
)
def test_what_none_may_do_is_noticed(misbehaving, reader, kind, text):
    outcome = misbehaving.answer(reader, 0)
    assert (outcome.kind, text in outcome.text) == (kind, True), outcome
    # Whatever it was, there is a process for the next case.
    assert misbehaving.answer("good", 0).kind == "read"


def test_a_worker_that_waits_for_ever_is_ended(misbehaving, monkeypatch):
    assert misbehaving.answer("good", 0).kind == "read"
    monkeypatch.setattr(campaign, "HANG", 0.5)
    assert misbehaving.answer("sleep", 0).kind == "hang"


@pytest.fixture(scope="module")
def misbehaving(tmp_path_factory):
    folder = tmp_path_factory.mktemp("workers")
    worker = campaign.Worker(folder, "fuzz.misbehaving")
    yield worker
    worker.close()


def test_failing_files_are_kept(tmp_path, monkeypatch):
    """As the worker saw them, made anew of their seed."""

    class Failing(campaign.Worker):
        def answer(self, name, seed):
            return campaign.Outcome(name, seed, "crash", "dead", "a trace")

    monkeypatch.setattr(campaign, "Worker", Failing)
    campaign.run([("rmmi", 3)], keep=tmp_path)
    (case,) = tmp_path.iterdir()
    assert case.name == "rmmi-3"
    assert (case / "outcome.txt").read_text() == "crash: dead\n\na trace"
    assert [path.name for path in (case / "files").iterdir()] == ["s.json"]


def test_a_seed_makes_the_same_files_again():
    good = {"a.json": b'{"a": [1, 2, 3], "b": 5}', "b.txt": b"1 2 3\n" * 20}
    cases = [mutated(good, good, random.Random(seed)) for seed in range(200)]
    again = [mutated(good, good, random.Random(seed)) for seed in range(200)]
    assert cases == again
    assert len({repr(sorted(case.items())) for case in cases}) > 150


def test_cases_come_in_turn():
    cases = interleaved(["a", "b"], 7)
    assert [next(cases) for _ in range(3)] == [("a", 7), ("b", 7), ("a", 8)]
