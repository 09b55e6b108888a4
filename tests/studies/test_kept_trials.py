"""Trials whose results are kept: what is done again, and what is not."""

import dataclasses as dc
import json

import pytest

from apps.studies.kept_trials import read_results, run_missing
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.pool import Job


@dc.dataclass(frozen=True)
class Case:
    key: str


@dc.dataclass(frozen=True)
class Result:
    key: str
    value: int = 0
    error: str = ""


def restore(fields: dict) -> Result:
    return Result(**fields)


def jobs(done: list[str], *keys: str) -> list[Job]:
    def run(case: Case) -> Result:
        done.append(case.key)
        if case.key == "bad":
            raise ValueError("no map")
        return Result(case.key, len(done))

    return [
        Job(Case(key), run, lambda case, error: Result(case.key, error=error))
        for key in keys
    ]


def test_only_what_is_missing_or_has_failed_runs(tmp_path):
    path, done = tmp_path / "results.jsonl", []
    first = run_missing(jobs(done, "a", "bad"), path, restore, 0)
    assert first[0] == Result("a", 1) and "no map" in first[1].error
    # A kill has torn the last line.
    with path.open("a") as file:
        file.write('{"key": "b", "val')
    later = run_missing(jobs(done, "b", "bad", "a"), path, restore, 0)
    assert done == ["a", "bad", "b", "bad"]
    assert [r.key for r in later] == ["b", "bad", "a"]
    assert later[2] == Result("a", 1)
    assert set(read_results(path, restore)) == {"a", "b"}


@pytest.mark.parametrize("line", ["[]", "{}", "no", '{"key": 1, "error": ""}'])
def test_another_file_is_refused_by_its_line(tmp_path, line):
    path = tmp_path / "results.jsonl"
    good = json.dumps(dc.asdict(Result("a")))

    def strict(fields: dict) -> Result:
        return Result(fields["key"].lower(), fields["value"])

    path.write_text(f"{good}\n{line}\n")
    with pytest.raises(FileError, match=r"results\.jsonl.*line 2 is no result"):
        read_results(path, strict)
