"""A minute of the campaign; and that it notices what it is there for."""

import random
from pathlib import Path

import pytest

from . import campaign
from .formats import FORMATS, interleaved
from .mutations import mutated

SEEDS = 10
"""Of each format in the suite; `python -m tests.fuzz` goes on from there."""

ANY_BYTES = ("pose-target", "velocity-target", "base-status")
"""Formats of numbers alone: almost any bytes are a message."""

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
        assert kinds["refused"] > 0 or name in ANY_BYTES


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
    # After any fault, there is a process for the next case.
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


def test_failing_files_are_kept(tmp_path):
    cases = [("good", 0), ("raise", 0), ("crash", 0), ("refuse", 0)]
    campaign.run(cases, keep=tmp_path, module="fuzz.misbehaving")
    kept = sorted(tmp_path.iterdir())
    assert [case.name for case in kept] == ["crash-0", "raise-0"]
    for case in kept:
        assert (case / "files" / "file").read_bytes() == b"content"
    outcome = (tmp_path / "raise-0" / "outcome.txt").read_text()
    assert outcome.startswith("traceback: ValueError at misbehaving.py")
    assert "Traceback" in outcome


def test_a_seed_makes_the_same_files_again():
    good = {"a.json": b'{"a": [1, 2, 3], "b": 5}', "b.txt": b"1 2 3\n" * 20}
    cases = [mutated(good, good, random.Random(seed)) for seed in range(200)]
    again = [mutated(good, good, random.Random(seed)) for seed in range(200)]
    assert cases == again
    assert len({repr(sorted(case.items())) for case in cases}) > 150


def test_cases_come_in_turn():
    cases = interleaved(["a", "b"], 7)
    assert [next(cases) for _ in range(3)] == [("a", 7), ("b", 7), ("a", 8)]
