"""Measured figures, inserted from results files while the pages are built.

`docs/results/NAME.yaml` contains the figures of the page `NAME.md`:
measurements with date, commit and machine, each with a table or with values,
and the settings that the page itself may contain. On the page, `{{ tick }}` is
replaced by the table of the measurement `tick`, and `{{ tick.median }}` by one
of its values.

The README is not built. In it, each figure is between `<!-- speed.tick -->` and
`<!-- -->`, and is compared with the measurement of this name.
"""

import dataclasses as dc
import datetime
import re
from pathlib import Path

import yaml
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[2]
README_SETTINGS = "benchmark", "speed"
"""Names of the results files whose settings the README may contain."""

_NUMBER = r"[−-]?\d[\d,]*(?:\.\d+)?(?:e[+-]?\d+)?"
_MORE = r",?\s(?:to|and|or|→)\s|\s?/\s?|\s\+\s|,\s|\s\[(?=[\d.]+, [\d.]+\])"
_LITERAL = re.compile(
    rf"(?<![\w.,/−-]){_NUMBER}(?:(?:{_MORE}){_NUMBER}\]?)*"
    r"\s?(?:ms|s|mm|%)(?![\w²/])"
)
"""Pattern of a figure with a unit, or of a list or range of figures."""

_CODE = re.compile(r"^```.*?^```|`[^`\n]+`|\]\([^)\s]*\)", re.M | re.S)
_PLACE = re.compile(r"\{\{\s*(\w+)(?:\.(\w+))?\s*\}\}")
_MARKED = re.compile(r"<!-- (\w+)\.(\w+) -->(.*?)<!-- -->", re.S)


@dc.dataclass(frozen=True)
class Measurement:
    """The figures that were measured at one time on one machine.

    Attributes:
        date: Day on which the figures were recorded.
        commit: Commit that recorded them.
        machine: The computer, and its load.
        table: A table in Markdown; empty if there is none.
        values: Single figures, by name.
    """

    date: datetime.date
    commit: str
    machine: str
    table: str = ""
    values: dict[str, str] = dc.field(default_factory=dict)

    @property
    def origin(self) -> str:
        """Date, commit and machine, as one line of text."""
        day = f"{self.date:%d %B %Y}".lstrip("0")
        return f"Recorded {day}, commit {self.commit}; machine: {self.machine}"

    def has(self, figure: str) -> bool:
        """Returns whether a figure is a value, or a part of the table."""
        cells = [" ".join(c.split()) for c in re.split(r"[|*\n]", self.table)]
        known = {*cells, *self.values.values()}
        for cell in cells:
            known |= set(cell.split(" / "))
        return " ".join(figure.split()) in known


@dc.dataclass(frozen=True)
class Figures:
    """The figures of a page.

    Attributes:
        settings: The literals that the page itself may contain, each with its
            meaning.
        measurements: The measurements, by name.
    """

    settings: dict[str, str]
    measurements: dict[str, Measurement]

    @staticmethod
    def read(name: str) -> "Figures":
        """Reads the results file of a page."""
        path = ROOT / "docs" / "results" / f"{name}.yaml"
        data = yaml.safe_load(path.read_text())
        measured = data["measurements"].items()
        return Figures(
            data["settings"],
            {key: Measurement(**entry) for key, entry in measured},
        )


def strays(text: str, settings: dict[str, str]) -> list[str]:
    """Finds numbers with a unit in a page that are not declared as settings.

    Numbers in code and in addresses are ignored.

    Args:
        text: Markdown, without the inserted measurements.
        settings: The allowed literals, such as "50 Hz".
    """
    found = _LITERAL.findall(_CODE.sub(" ` ", text))
    return [f for f in map(_spaced, found) if f not in settings]


def with_figures(markdown: str, figures: Figures) -> str:
    """Inserts the figures of a results file, and a table of their origins.

    Args:
        markdown: The page.
        figures: Its figures.

    Raises:
        PluginError: The page contains a figure that is not a setting, or
            names a figure that does not exist.
    """
    text = _PLACE.sub(" ", markdown)
    if "{{" in text:
        raise PluginError("a place for a figure that names none")
    wrong = strays(text, figures.settings)
    if wrong:
        raise PluginError(
            f"figures that are neither measured nor settings: {wrong}"
        )
    used: dict[str, Measurement] = {}

    def insert(match: re.Match[str]) -> str:
        name, value = match.groups()
        entry = figures.measurements.get(name)
        if entry is None or (value or entry.table) not in (
            *entry.values,
            entry.table,
        ):
            raise PluginError(f"no figure {match[0]}")
        used[name] = entry
        if value:
            return entry.values[value]
        return f"{entry.table}\n*{entry.origin}.*\n{{: .measured }}\n"

    page = _PLACE.sub(insert, markdown)
    rows = "\n".join(
        f"| {name.replace('_', ' ')} | {entry.date} | {entry.commit}"
        f" | {entry.machine} |"
        for name, entry in used.items()
    )
    return (
        f"{page}\n\n## Measurements\n\nThe table states when and where the"
        " figures of this page were recorded. The date is that of the commit."
        "\n\n| measurement | date | commit | machine |\n|---|---|---|---|\n"
        f"{rows}\n"
    )


def readme_faults(text: str) -> list[str]:
    """Finds figures of the README that no results file contains.

    Args:
        text: The README.
    """
    faults = [
        f"{page}.{name} has no {figure!r}"
        for page, name, figure in _MARKED.findall(text)
        if not Figures.read(page).measurements[name].has(figure)
    ]
    settings = {}
    for page in README_SETTINGS:
        settings |= Figures.read(page).settings
    return faults + strays(_MARKED.sub(" ", text), settings)


def _spaced(literal: str) -> str:
    return " ".join(literal.split())


def on_pre_build(config: MkDocsConfig) -> None:
    """Checks the README before the build."""
    faults = readme_faults((ROOT / "README.md").read_text())
    if faults:
        raise PluginError(f"README.md: {faults}")


def on_page_markdown(markdown: str, page: Page, **_) -> str:
    """Inserts the figures into a page of results."""
    path = Path(page.file.src_uri)
    if path.parent.name != "results":
        return markdown
    try:
        return with_figures(markdown, Figures.read(path.stem))
    except PluginError as error:
        raise PluginError(f"{path}: {error}") from None
