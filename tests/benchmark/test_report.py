"""Reports: hand-made results, and what their tables must say."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.base.table import Table
from remosplat_drake.benchmark.cells import format_mean, format_rate
from remosplat_drake.benchmark.report import (
    main_table,
    outcome_table,
    paired_table,
    report_tables,
    station_tables,
    to_markdown,
)
from remosplat_drake.benchmark.report_page import to_html
from remosplat_drake.benchmark.result import COLLISION, LOCAL_MINIMUM, SUCCESS
from remosplat_drake.benchmark.scan_table import scan_table
from remosplat_drake.benchmark.summary import gather


def cells(table: Table, method: str) -> dict[str, str]:
    (row,) = [row for row in table.rows if row[0] == method]
    return dict(zip(table.header, row, strict=True))


def test_rows_are_gathered_by_set_up_and_scenes(make_result):
    results = [
        make_result("sdf-active", "b"),
        make_result("sdf-hard", "b"),
        make_result("sdf-hard", "a"),
        make_result("sdf-active", "a"),
        make_result("sdf-hard", "a", spheres="covering"),
        make_result("mine", "a"),
    ]
    comparisons = gather(results)
    found = [[row.method for row in c.rows] for c in comparisons]
    assert sorted(found) == [["mine"], ["sdf-hard"], ["sdf-hard", "sdf-active"]]
    both = comparisons[[len(x) for x in found].index(2)]
    assert both.rows[0].scenes == (("a", 0), ("b", 0))


def test_averages_are_over_scenes_that_all_solve(make_result):
    results = [
        make_result("sdf-hard", "a", distance=0.1),
        make_result("sdf-hard", "b", distance=0.5),
        make_result("sdf-active", "a", distance=0.2),
        make_result("sdf-active", "b", text=LOCAL_MINIMUM, distance=0.7),
    ]
    (comparison,) = gather(results)
    np.testing.assert_array_equal(comparison.common("text"), [True, False])
    table = main_table(comparison, "text")
    assert cells(table, "sdf-hard")["avg distance† [m]"] == "0.100"
    assert cells(table, "sdf-active")["avg distance† [m]"] == "0.200"
    assert "over the 1 scenes" in table.notes
    both = main_table(comparison, "authors")
    assert cells(both, "sdf-hard")["avg distance† [m]"].startswith("0.300 ±")


def test_the_papers_rows_stand_below_ours(make_result):
    (comparison,) = gather([make_result(), make_result("mine")])
    labels = [row[0] for row in main_table(comparison, "text").rows]
    assert labels == ["sdf-hard", "paper: RMMI, ground truth, hard", "mine"]
    paper = main_table(comparison, "text").rows[1]
    assert "77.8 [75.1, 80.3] (778/1000)" in paper


def test_failures_and_collisions_are_counted(make_result):
    results = [
        make_result(scene="a"),
        make_result(scene="b", text=LOCAL_MINIMUM, authors=LOCAL_MINIMUM),
        make_result(scene="c", text=COLLISION, authors=COLLISION),
        make_result(scene="d", text=None, authors=None, error="oops"),
    ]
    results[3] = dc.replace(results[3], text=None, authors=None)
    (comparison,) = gather(results)
    outcomes = cells(outcome_table(comparison), "sdf-hard")
    assert outcomes == {
        "method": "sdf-hard",
        "trials": "4",
        "success": "1",
        "collision": "1",
        "local minimum": "1",
        "crash": "1",
    }
    row = cells(main_table(comparison, "text"), "sdf-hard")
    assert row["success [%]"] == "25.0 [4.6, 69.9] (1/4)"
    assert row["collisions"].startswith("1/4")


def test_paired_counts(make_result):
    results = [
        make_result(method, scene, text=outcome)
        for method, outcomes in {
            "sdf-hard": ("success", "success", LOCAL_MINIMUM),
            "sdf-active": ("success", LOCAL_MINIMUM, LOCAL_MINIMUM),
        }.items()
        for scene, outcome in zip("abc", outcomes, strict=True)
    ]
    (comparison,) = gather(results)
    row = cells(paired_table(comparison), "sdf-active")
    assert row["only this, text"] == "0"
    assert row["only sdf-hard, text"] == "1"
    assert row["p, text"] == "1"


def test_scans_stand_beside_the_papers_tables_two_and_three(make_result):
    results = [
        make_result(
            "depth-hard",
            f"kitchen/{scene}",
            text=outcome,
            family=family,
            suite=f"kitchen, {family} map",
            splat="trained",
            splat_count=50_000,
        )
        for scene, family, outcome in (
            ("mug", "scan", "success"),
            ("cupboard", "scan", LOCAL_MINIMUM),
            ("mug", "noisy scan", COLLISION),
            ("cupboard", "noisy scan", LOCAL_MINIMUM),
        )
    ]
    noisy, clean = (scan_table(c, "text") for c in gather(results))
    row = cells(clean, "depth-hard")
    assert (row["success"], row["collisions"]) == ("1/2", "0/2")
    assert row["not reached"] == "local minimum: cupboard"
    assert row["gracefulness [m/s²]"] == "0.400"
    paper = cells(clean, "paper: depth rasterisation")
    assert (paper["success"], paper["gracefulness [m/s²]"]) == ("6/7", "0.196")
    row = cells(noisy, "depth-hard")
    assert (row["success"], row["collisions"]) == ("0/2", "1/2")
    assert cells(noisy, "paper: sphere-to-ellipsoid")["success"] == "0/7"
    # Nothing of Table I stands in a report about scans.
    assert "RMMI" not in to_markdown(report_tables(results), "Scans")


def test_stations_are_compared_where_both_have_run(make_result):
    results = [make_result(scene=scene) for scene in "ab"]
    assert station_tables(gather(results)) == []
    results += [
        make_result(scene="a", station="dynamic"),
        make_result(scene="b", station="dynamic", text=LOCAL_MINIMUM),
    ]
    (table,) = station_tables(gather(results))
    row = cells(table, "sdf-hard, paper spheres")
    assert row["only kinematic"] == "1"
    assert row["only dynamic"] == "0"


def test_the_splats_origin_is_in_every_table(make_result):
    result = make_result("ellipsoid-hard", splat="surfel", splat_count=60_000)
    text = to_markdown(report_tables([result]), "Benchmark")
    assert text.count("surfel, 60k") == 3
    assert "| ellipsoid-hard" in text


def test_rates_show_their_counts():
    assert format_rate(997, 1000) == "99.7 [99.1, 99.9] (997/1000)"
    # Published: 841 of 1000 is 81.7 to 86.2 %.
    assert format_rate(841, 1000) == "84.1 [81.7, 86.2] (841/1000)"
    assert format_rate(0, 10) == "0.0 [0.0, 27.8] (0/10)"
    assert format_rate(10, 10) == "100.0 [72.2, 100.0] (10/10)"
    assert format_rate(0, 0) == "–"


def test_means_show_their_intervals():
    # The standard deviation is sqrt(5/3), and 1.96 sqrt(5/3) / 2 = 1.265.
    values = np.array([1.0, 2.0, 3.0, 4.0])
    assert format_mean(values, 3) == "2.500 ± 1.265"
    assert format_mean(values[:1], 1) == "1.0"
    assert format_mean(values[:0], 1) == "–"


def test_pairs_count_only_where_two_methods_differ(make_result):
    results = [
        make_result(method, scene, text=outcome)
        for method, others in (("sdf-hard", SUCCESS), ("mine", LOCAL_MINIMUM))
        for scene, outcome in zip(
            "abcdef", [SUCCESS, *[others] * 5], strict=True
        )
    ]
    (comparison,) = gather(results)
    row = cells(paired_table(comparison), "mine")
    # Five tosses that all fall on one side: 2 / 2^5.
    assert row["only sdf-hard, text"] == "5"
    assert row["p, text"] == "0.0625"
    assert row["p, authors"] == "1"


def test_tables_as_markdown_and_html():
    table = Table("a < b", ("x", "y"), (("1", "2"), ("long", "3")), "note")
    assert table.to_markdown() == (
        "### a < b\n\n"
        "| x    |   y |\n| ---- | --: |\n"
        "| 1    |   2 |\n| long |   3 |\n\nnote\n"
    )
    assert "<h3>a &lt; b</h3>" in table.to_html()
    assert '<td class="text">long</td><td>3</td>' in table.to_html()


def test_the_page_holds_plots_and_tables(make_result):
    results = [
        make_result(method, scene)
        for method in ("sdf-hard", "sdf-active")
        for scene in "abc"
    ]
    page = to_html(results, report_tables(results), "Numbers & plots")
    assert "<h1>Numbers &amp; plots</h1>" in page
    # Success, clearance, acceleration, time; no splats, no rate over them.
    assert page.count("<svg") == page.count("<figcaption>") == 4
    # The overview, and six.
    assert page.count("<table>") == 7
    assert "<?xml" not in page
    results += [
        make_result("depth-hard", x, splat="surfel", splat_count=60_000)
        for x in "abc"
    ]
    assert "Control rate and splats" in to_html(results, [], "x")


def test_a_page_of_crashes_is_still_a_page(make_result):
    crashed = make_result(text=None, authors=None, times=None, error="no")
    crashed = dc.replace(crashed, text=None, authors=None)
    assert "<svg" in to_html([crashed], [], "x")


@pytest.mark.parametrize("outcome", [SUCCESS, LOCAL_MINIMUM])
@pytest.mark.parametrize("count", [3, 7, 49])
def test_plots_stand_rates_of_none_and_all(make_result, outcome, count):
    """An interval's end may lie a rounding error beyond its rate."""
    results = [
        make_result(scene=f"{i}", text=outcome, authors=outcome)
        for i in range(count)
    ]
    assert "<svg" in to_html(results, [], "x")
