"""The prose of all code and pages is plain; CONTRIBUTING has the rules.

Prose is docstrings, comments and the texts of errors and reports, in the
package, in apps/ and in tests/, and the pages of docs/.
"""

import ast
import io
import re
import tokenize
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "remosplat_drake"
PARENTS = PACKAGE, ROOT / "apps", ROOT / "tests", ROOT / "docs"
PAGES = sorted(
    str(path.relative_to(ROOT / "docs")) for path in ROOT.glob("docs/**/*.md")
)

_FORBIDDEN = re.compile(
    r"\b(who|whom|whoever|nobody|somebody|anybody|whatever|lest|thereof)\b",
    re.IGNORECASE,
)
# Only people are "who".
_PEOPLE = re.compile(r"\b(person|people|operators?|readers?|users?) who\b")
_OPENING = re.compile(r'(?:#.*\n|\s)*r?"""(.*)')
"""The first line of a module's docstring."""
_QUESTION = re.compile(
    r"(`[^`]+`: )?(what|which|who|where|when|why|whether|how)\b",
    re.IGNORECASE,
)


def docstrings(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """The docstrings in a module, those below fields, too, with their lines."""
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        for statement in body if isinstance(body, list) else []:
            match statement:
                case ast.Expr(value=ast.Constant(value=str(text))):
                    yield statement.lineno, text


def messages(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """The texts of three words or more in a module, with their lines."""
    for node in ast.walk(tree):
        match node:
            case ast.Constant(value=str(text)) if len(text.split()) > 2:
                yield node.lineno, text


def comments(source: str) -> Iterator[tuple[int, str]]:
    """The comments of a module, with their lines."""
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string


def forbidden(text: str) -> list[str]:
    """The forbidden words of a text."""
    text = _PEOPLE.sub("", " ".join(text.split()))
    return [word.lower() for word in _FORBIDDEN.findall(text)]


def prose_faults(source: str) -> list[str]:
    """Forbidden words in a module's prose, with their lines."""
    # Parsing takes a hundred times as long.
    if not _FORBIDDEN.search(source):
        return []
    tree = ast.parse(source)
    prose = {*docstrings(tree), *messages(tree), *comments(source)}
    return sorted(
        f"{line}: {word}" for line, text in prose for word in forbidden(text)
    )


def faults_of_module(source: str) -> list[str]:
    """Forbidden words in a module, and a first line that is no statement."""
    faults = prose_faults(source)
    opening = _OPENING.match(source)
    first = opening[1].removesuffix('"""') if opening else ""
    if not first.endswith(".") or _QUESTION.match(first):
        faults.append(f"1: {first}")
    return faults


def modules_by_folder() -> dict[str, list[Path]]:
    """The modules of each room, and of each folder of apps and tests."""
    found = defaultdict(list)
    for parent in PARENTS:
        for path in sorted(parent.rglob("*.py")):
            parts = path.relative_to(ROOT).parts
            is_ours = (
                "This file automatically generated" not in path.read_text()
            )
            # This file quotes faults.
            if is_ours and path != Path(__file__):
                found["/".join(parts[: min(2, len(parts) - 1)])].append(path)
    return dict(found)


MODULES = modules_by_folder()


@pytest.mark.parametrize("folder", MODULES)
def test_a_folder_is_in_plain_words(folder):
    modules = MODULES[folder]
    faults = {
        str(path.relative_to(ROOT)): found
        for path in modules
        if (found := faults_of_module(path.read_text()))
    }
    assert not faults


@pytest.mark.parametrize("page", PAGES)
def test_a_page_is_in_plain_words(page):
    assert not forbidden((ROOT / "docs" / page).read_text())


@pytest.mark.parametrize(
    ("source", "fault"),
    [
        ('"""Kernels.\n\nNone is compiled for nobody."""', "1: nobody"),
        ('"""A map."""\n# Whatever it holds.', "2: whatever"),
        ('"""A map."""\nx = 1\n"""None if somebody asks."""', "3: somebody"),
        ('"""A map."""\nraise OSError("who asks must wait")', "2: who"),
        ('"""What a map knows."""', "1: What a map knows."),
        ('"""`Map`: where things are."""', "1: `Map`: where things are."),
        ('"""A map"""', "1: A map"),
        ("x = 1", "1: "),
    ],
)
def test_a_planted_fault_is_found(source, fault):
    assert faults_of_module(source) == [fault]


def test_plain_words_pass():
    source = '"""A map.\n\nA person who stands in view is masked."""'
    assert not faults_of_module(source)
