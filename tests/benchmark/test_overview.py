"""A comparison at a glance, of hand-made results."""

import pytest

from remosplat_drake.benchmark.overview import (
    document,
    headline,
    overview_table,
)
from remosplat_drake.benchmark.report_page import to_html
from remosplat_drake.benchmark.result import COLLISION, LOCAL_MINIMUM
from remosplat_drake.benchmark.summary import gather
from remosplat_drake.commands.json_output import json_text


@pytest.fixture
def results(make_result):
    return [
        make_result("sdf-hard", "a"),
        make_result("sdf-hard", "b", text=LOCAL_MINIMUM),
        make_result("mine", "a"),
        make_result("mine", "b"),
        make_result("other", "a", text=COLLISION),
        make_result("other", "b", text=COLLISION),
    ]


def test_the_table_has_the_papers_rate_beside_ours(results):
    (comparison,) = gather(results)
    rows = {row[0]: row for row in overview_table(comparison).rows}
    assert rows["sdf-hard"][1:4] == ("50.0 [9.5, 90.5] (1/2)", "77.8", "0")
    assert rows["mine"][1:4] == ("100.0 [34.2, 100.0] (2/2)", "", "0")
    assert rows["other"][3] == "2"


def test_the_headline_names_the_best(results):
    (comparison,) = gather(results)
    text = headline(comparison)
    assert text.startswith("mine reaches the most targets: 2 of 2 (34 to 100 %")
    assert "colliding never." in text
    assert "sdf-hard has the highest success in the paper, 77.8 %; here" in (
        text
    )
    (comparison,) = gather(results[:1])
    assert headline(comparison).startswith(
        "sdf-hard reaches the most targets: 1 of 1"
    )


def test_several_may_be_best(results):
    (comparison,) = gather([results[4], results[5]])
    assert "colliding 2 times." in headline(comparison)
    (comparison,) = gather([results[0], results[2]])
    text = headline(comparison)
    assert text.startswith("sdf-hard, mine reach the most targets: 1 of 1")


def test_the_page_begins_with_it(results):
    page = to_html(results, [], "x")
    assert '<p class="trust">mine reaches the most targets' in page
    assert "*" not in page.partition("<body>")[2].partition("<svg")[0]


def test_the_document_is_whole(results):
    (comparison,) = document(results)["comparisons"]
    assert json_text(comparison)
    first, *_ = comparison["methods"]
    assert set(first) == set(
        "method gains splat trials reached collisions least_clearance"
        " tick_p50 tick_p99 paper moving carrying".split()
    )
    assert first["method"] == "sdf-hard"
    assert first["reached"] == {"text": 1, "authors": 2}
    assert first["paper"] == {"trials": 1000, "reached": 778}
