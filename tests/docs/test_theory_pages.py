"""Each theory page names the functions that compute it, and they exist."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(ROOT.glob("docs/theory/*.md"))


def functions_of(page: str) -> list[tuple[str, str]]:
    """The functions that a page names, each with its file."""
    section = page.partition("\n## In the code\n")[2].partition("\n## ")[0]
    return re.findall(r"\| `(\w+)` in `([\w/]+\.py)` \|$", section, re.M)


def missing(page: str) -> list[str]:
    """The named functions that their files do not have."""
    found = []
    for name, file in functions_of(page):
        path = ROOT / "remosplat_drake" / file
        tree = ast.parse(path.read_text()) if path.is_file() else ast.Module([])
        nodes = [n for n in tree.body if isinstance(n, ast.FunctionDef)]
        if name not in {node.name for node in nodes}:
            found.append(f"{name} in {file}")
    return found


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_a_theory_page_names_functions_that_exist(path):
    page = path.read_text()
    assert len(functions_of(page)) >= 5
    assert missing(page) == []


def test_functions_and_files_that_are_gone_are_found():
    page = """
## In the code

| what | function |
|---|---|
| the supervisor | `supervise` in `safety/supervisor.py` |
| gone | `superwise` in `safety/supervisor.py` |
| gone, too | `supervise` in `safety/gone.py` |
"""
    assert missing(page) == [
        "superwise in safety/supervisor.py",
        "supervise in safety/gone.py",
    ]
