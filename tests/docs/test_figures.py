"""Measured figures come from results files, or the build fails."""

import datetime
import re
from pathlib import Path

import pytest

pytest.importorskip("mkdocs")

from figures import (
    Figures,
    Measurement,
    readme_faults,
    strays,
    with_figures,
)
from mkdocs.exceptions import PluginError

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text()
PAGES = sorted(path.stem for path in ROOT.glob("docs/results/*.md"))

TICK = Measurement(
    datetime.date(2026, 11, 5),
    "0123abc",
    "one core",
    "| | median |\n|---|---:|\n| tick | 0.53 / 0.70 |\n",
    {"start": "1.5 s"},
)
FIGURES = Figures({"21 mm": "stopping distance"}, {"tick": TICK})


def places(text: str) -> set[str]:
    return set(re.findall(r"\{\{ (\w+(?:\.\w+)?) \}\}", text))


@pytest.mark.parametrize("page", PAGES)
def test_a_page_of_results_inserts_all_its_figures(page):
    text = (ROOT / f"docs/results/{page}.md").read_text()
    figures = Figures.read(page)
    assert "{{" not in with_figures(text, figures)
    listed = set()
    for name, entry in figures.measurements.items():
        listed |= {f"{name}.{value}" for value in entry.values}
        listed |= {name} if entry.table else set()
    elsewhere = {
        figure
        for figure in listed - places(text)
        if f"<!-- {page}.{figure.partition('.')[0]} -->" in README
    }
    assert places(text) | elsewhere == listed


@pytest.mark.parametrize("page", PAGES)
def test_a_measurement_has_date_commit_and_machine(page):
    for entry in Figures.read(page).measurements.values():
        assert isinstance(entry.date, datetime.date)
        assert re.fullmatch("[0-9a-f]{7,}", entry.commit)
        assert entry.machine


def test_tables_and_values_come_with_their_origin():
    page = with_figures("{{ tick }}\nIn {{\ntick.start }}.", FIGURES)
    assert "| tick | 0.53 / 0.70 |" in page
    assert "In 1.5 s." in page
    assert "Recorded 5 November 2026, commit 0123abc; machine: one core" in page


@pytest.mark.parametrize(
    "text",
    [
        "It takes 12 ms.",
        "All but 3 %.",
        "{{ tock }}",
        "{{ tick.end }}",
        "{{ tick.start",
    ],
)
def test_what_no_results_file_has_ends_the_build(text):
    with pytest.raises(PluginError):
        with_figures(text, FIGURES)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("It keeps 21 mm.", []),
        ("It keeps 22 mm.", ["22 mm"]),
        ("5.1 /\n6.5 ms", ["5.1 / 6.5 ms"]),
        ("0.5 to 0.7 ms and 99.7 [99.1, 99.9] %", None),
        ("`12 ms`, 8 mm/s, 3 msgs and [a](b#12-ms)", []),
    ],
)
def test_figures_with_units_are_found(text, found):
    if found is None:
        found = ["0.5 to 0.7 ms", "99.7 [99.1, 99.9] %"]
    assert strays(text, FIGURES.settings) == found


def test_the_readme_has_only_figures_that_were_measured():
    assert readme_faults(README) == []


def test_a_planted_figure_of_the_readme_is_found():
    assert readme_faults("A tick takes 0.01 ms.") == ["0.01 ms"]
    (fault,) = readme_faults("<!-- speed.tick -->0.01<!-- --> ms")
    assert fault == "speed.tick has no '0.01'"


def test_the_readme_tells_the_motion_time():
    assert re.search(r"Motion takes <!-- \w+\.\w+ -->[\d.]+<!-- --> s", README)


@pytest.mark.parametrize("word", ["never collides", "always reaches"])
def test_claims_tell_their_scope(word):
    pages = [README, *(p.read_text() for p in ROOT.glob("docs/**/*.md"))]
    assert not any(word in page for page in pages)
