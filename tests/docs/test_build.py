"""The command of `make docs` fails on every warning of the build."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mkdocs")
pytest.importorskip("material")

ROOT = Path(__file__).resolve().parents[2]


def build(
    folder: Path,
    pages: dict[str, str],
    nav: str = "index.md",
    hooks: str = "",
) -> subprocess.CompletedProcess:
    """Builds a site of small pages with the project's settings.

    Plugins and other hooks are left out: they take most of the time.
    """
    for name, text in pages.items():
        path = folder / f"docs/{name}.md"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    (folder / "mkdocs.yml").write_text(
        f"INHERIT: {ROOT / 'mkdocs.yml'}\n"
        f"nav: [{nav}]\nhooks: [{hooks}]\nplugins: []\nextra_css: []\n"
    )
    recipe = re.search(
        r"^docs:.*\n\t(.+)$", (ROOT / "Makefile").read_text(), re.M
    )
    assert recipe is not None
    command = recipe[1].replace("$(BIN)", str(Path(sys.executable).parent))
    return subprocess.run(
        command.replace("$(ARGS)", ""),
        shell=True,
        cwd=folder,
        capture_output=True,
        text=True,
    )


def test_a_page_without_faults_is_built(tmp_path):
    text = "# Start\n\n[Up](#start), by Ada[^a].\n\n[^a]: A."
    found = build(tmp_path, {"index": text})
    assert found.returncode == 0, found.stderr
    assert (tmp_path / "site/index.html").exists()


@pytest.mark.parametrize(
    ("pages", "culprit"),
    [
        ({"index": "[Gone](gone.md)"}, "gone.md"),
        pytest.param(
            {"index": "[Gone](#gone)"}, "#gone", marks=pytest.mark.slow
        ),
        ({"index": "Text.\n\n[^a]: Never used."}, "#fnref:a"),
        pytest.param(
            {"index": "Text.", "left_out": "Text."},
            "left_out.md",
            marks=pytest.mark.slow,
        ),
    ],
    ids=["link", "anchor", "footnote", "navigation"],
)
def test_a_warning_fails_the_build(tmp_path, pages, culprit):
    found = build(tmp_path, pages)
    assert found.returncode != 0
    assert culprit in found.stderr


def test_a_page_of_the_navigation_that_is_missing_fails_the_build(tmp_path):
    found = build(tmp_path, {"index": "Text."}, nav="index.md, gone.md")
    assert found.returncode != 0
    assert "gone.md" in found.stderr


def test_a_figure_that_was_not_measured_fails_the_build(tmp_path):
    found = build(
        tmp_path,
        {"results/speed": "It takes 12 ms."},
        nav="results/speed.md",
        hooks=str(ROOT / "docs/hooks/figures.py"),
    )
    assert found.returncode != 0
    assert "results/speed.md" in found.stderr and "12 ms" in found.stderr
