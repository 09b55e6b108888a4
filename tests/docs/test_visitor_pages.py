"""Pages for a first visit: extras, sentences and links match the code."""

import ast
import json
import re
import tomllib
from functools import cache
from pathlib import Path

import pytest
from sources import modules, nodes

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PACKAGE = ROOT / "remosplat_drake"

_VARIABLE = "\0"
"""The place of a value in the text of an f-string."""

_PLACEHOLDER = re.compile(r"\b[A-Z]+\b")
"""The place of a value in a sentence of the page: a word in capitals."""


def cells(page: str, header: str) -> list[str]:
    """First cells of the rows of all tables with such a header."""
    found = []
    for table in (DOCS / page).read_text().split(f"| {header} |")[1:]:
        rows = table.partition("\n\n")[0].splitlines()[2:]
        found += [row.strip("|").split(" | ")[0].strip() for row in rows]
    return found


@cache
def texts() -> list[str]:
    """All texts that the package can print, with places for values."""
    found = []
    for module in modules():
        for node in nodes(module):
            match node:
                case ast.JoinedStr(values=parts):
                    found.append(
                        "".join(
                            part.value
                            if isinstance(part, ast.Constant)
                            else _VARIABLE
                            for part in parts
                        )
                    )
                case ast.Constant(value=str(text)):
                    found.append(text)
    for script in PACKAGE.rglob("*.js"):
        found += re.findall(r"[`\"']([^`\"'\n]{4,})[`\"']", script.read_text())
    return found


def is_printed(sentence: str) -> bool:
    """Whether one text has all fixed parts of a sentence, in this order."""
    parts = [part.strip() for part in _PLACEHOLDER.split(sentence)]
    pattern = re.compile(".*".join(map(re.escape, filter(None, parts))), re.S)
    return any(pattern.search(text) for text in texts())


SENTENCES = [
    sentence
    for cell in cells("troubleshooting.md", "the program prints")
    for sentence in re.findall(r"`([^`]+)`", cell)
]


@pytest.mark.parametrize("sentence", SENTENCES)
def test_every_quoted_sentence_is_printed(sentence):
    assert is_printed(sentence)


def test_a_sentence_that_the_code_does_not_have_is_found():
    assert is_printed("clearance N mm is below N mm")
    assert not is_printed("clearance N mm is above N mm")
    assert len(SENTENCES) > 40


def test_the_front_page_lists_all_extras():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    listed = [cell.strip("`") for cell in cells("index.md", "extra")]
    assert sorted(listed) == sorted(project["optional-dependencies"])


def test_the_front_page_offers_three_paths_and_a_moving_picture():
    page = (DOCS / "index.md").read_text()
    assert "images/tour.webp" in page
    for path in ("run-it", "use-it-in-python", "connect-a-robot"):
        assert f"(#{path})" in page


def test_figures_of_others_are_marked_as_published():
    page = " ".join((DOCS / "comparison.md").read_text().split())
    assert "*published*" in page
    without = re.sub(r"(?<!\*)\*[^*]+\*(?!\*)", "", page)
    assert re.findall(r"\d+ ?(?:µs|ms|s|mm|%)(?!\w)", without) == []


def test_the_glossary_is_in_alphabetical_order():
    terms = re.findall(
        r"^- \*\*(.+?)\*\*", (DOCS / "glossary.md").read_text(), re.M
    )
    assert len(terms) > 40
    assert terms == sorted(terms, key=str.lower)


@pytest.mark.parametrize(
    ("word", "page"),
    [("ROS", "drivers"), ("URDF", "robot"), ("gripper", "hardware")],
)
def test_search_finds(word, page, search_index):
    found = [
        entry["location"].partition("#")[0]
        for entry in search_index["docs"]
        if re.search(rf"\b{word}", entry["title"] + entry["text"])
    ]
    assert {"index.html", f"guides/{page}.html"} <= set(found)


@pytest.fixture(scope="module")
def search_index(tmp_path_factory) -> dict:
    """The search index of some of the project's pages, as mkdocs builds it."""
    pytest.importorskip("mkdocs")
    pytest.importorskip("material")
    from mkdocs.commands.build import build
    from mkdocs.config import load_config

    folder = tmp_path_factory.mktemp("site")
    (folder / "mkdocs.yml").write_text(
        f"INHERIT: {ROOT / 'mkdocs.yml'}\nstrict: false\n"
        f"docs_dir: {DOCS}\nsite_dir: {folder / 'site'}\nhooks: []\n"
        "plugins: [search]\nexclude_docs: |\n  hooks/\n  theory/\n"
        "  results/\nvalidation: {nav: {not_found: ignore, omitted_files:"
        " ignore}, links: {not_found: ignore, anchors: ignore}}\n"
    )
    build(load_config(str(folder / "mkdocs.yml")))
    index = folder / "site/search/search_index.json"
    return json.loads(index.read_text())
