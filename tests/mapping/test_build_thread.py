"""Maps are made in a thread, and what is told of it comes in order."""

import time

import pytest

from remosplat_drake.mapping.build_thread import BuildThread
from remosplat_drake.mapping.messages import Building


def fetched(builder: BuildThread[str]) -> str | Exception:
    while (result := builder.fetch()) is None:
        time.sleep(0.001)
    return result


def test_nothing_is_reported_after_the_result():
    builder: BuildThread[str] = BuildThread()

    def job(report):
        report("looking", 1, 1)
        return "a map"

    builder.start(job)
    assert fetched(builder) == "a map"
    assert builder.progress() is None
    assert not builder.is_busy


def test_a_report_is_told_once():
    builder: BuildThread[str] = BuildThread()
    is_over = False

    def job(report):
        report("looking", 1, 2)
        while not is_over:
            time.sleep(0.001)
        return "a map"

    builder.start(job)
    while (progress := builder.progress()) is None:
        time.sleep(0.001)
    assert progress == Building("looking", 1, 2)
    assert builder.progress() is None
    is_over = True
    assert fetched(builder) == "a map"


def test_the_error_that_a_job_ends_by_is_its_result():
    builder: BuildThread[str] = BuildThread()

    def job(report):
        raise ValueError("no map")

    builder.start(job)
    result = fetched(builder)
    assert isinstance(result, ValueError)
    with pytest.raises(ValueError, match="no map"):
        raise result
