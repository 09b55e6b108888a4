"""Result lines: there and back, and what interruptions leave."""

import dataclasses as dc

import pytest

from remosplat_drake.base.errors import FileError
from remosplat_drake.benchmark.result import (
    COLLISION,
    CRASH,
    SUCCESS,
    from_line,
    read_results,
    to_line,
)


def test_a_line_holds_everything(make_result):
    result = make_result(statuses={"optimal": 60})
    assert from_line(to_line(result), "here") == result
    crashed = make_result(text=SUCCESS, error="ValueError: no")
    assert from_line(to_line(crashed), "here").error == "ValueError: no"


def test_outcomes_by_both_rules(make_result):
    result = make_result(text=COLLISION, authors=SUCCESS)
    assert result.outcome("text") == COLLISION
    assert not result.success("text")
    assert result.success("authors")
    crashed = dc.replace(result, text=None, authors=None)
    assert crashed.outcome("text") == CRASH


def test_the_latest_line_of_a_key_counts_and_a_torn_one_does_not(
    tmp_path, make_result
):
    path = tmp_path / "trials.jsonl"
    assert read_results(path) == []
    first, second = make_result(), make_result(text=COLLISION)
    other = make_result(scene="b")
    lines = [to_line(x) for x in (first, other, second)]
    path.write_text("\n".join(lines) + "\n" + lines[0][:30])
    assert read_results(path) == [second, other]


def test_a_foreign_line_is_named(tmp_path, make_result):
    path = tmp_path / "trials.jsonl"
    path.write_text(to_line(make_result()) + '\n{"a": 1}\n')
    with pytest.raises(FileError, match=r"trials\.jsonl:2.*benchmark results"):
        read_results(path)
