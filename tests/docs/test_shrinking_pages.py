"""A commit that takes half of a page's words says so.

A copy of a page was once removed together with the page itself. So the message
of such a commit has a line `Shorter: docs/PAGE.md`, with the reason behind it.
"""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LATEST = 10
"""Number of commits that are looked at: CI runs for each push."""


def git(folder: Path, *arguments: str) -> str:
    command = ["git", "-C", str(folder), *arguments]
    return subprocess.run(command, capture_output=True, text=True).stdout


def words(folder: Path, commit: str, page: str) -> int:
    """How many words a page has in a commit, with its results file."""
    files = [page, page.replace(".md", ".yaml")]
    texts = [git(folder, "show", f"{commit}:{file}") for file in files]
    return len(" ".join(texts).split())


def unsaid(folder: Path, count: int) -> list[str]:
    """Pages that lost half of their words in a commit that does not say so."""
    found = []
    commits = git(
        folder, "log", f"-{count}", "--no-merges", "--format=%H", "--", "docs"
    )
    for commit in commits.split():
        message = git(folder, "show", "-s", "--format=%B", commit)
        said = re.findall(r"^Shorter: ([^\s,]+)", message, re.M)
        pages = git(
            folder, "diff", "--name-only", "--no-renames", f"{commit}^", commit
        )
        for page in pages.split():
            if not (page.startswith("docs/") and page.endswith(".md")):
                continue
            before, after = (
                words(folder, c, page) for c in (f"{commit}^", commit)
            )
            if 2 * after < before and page not in said:
                found.append(f"{commit[:8]} {page}: {before} to {after} words")
    return found


def test_no_page_has_lost_half_of_its_words_silently():
    if not git(ROOT, "rev-parse", "HEAD"):
        pytest.skip("no git repository")
    assert unsaid(ROOT, LATEST) == []


@pytest.mark.parametrize(
    ("message", "is_said"),
    [
        ("docs: Less", False),
        ("docs: Less\n\nShorter: docs/page.md, the rest is elsewhere", True),
    ],
)
def test_a_planted_loss_is_found(tmp_path, message, is_said):
    def commit(text: str, message: str):
        (tmp_path / "docs").mkdir(exist_ok=True)
        (tmp_path / "docs/page.md").write_text(text)
        git(tmp_path, "add", ".")
        author = ("-c", "user.name=A", "-c", "user.email=a@b.c")
        git(tmp_path, *author, "commit", "-qm", message)

    git(tmp_path, "init", "-q")
    commit("word " * 100, "docs: A page")
    commit("word " * 49, message)
    assert bool(unsaid(tmp_path, 1)) != is_said
