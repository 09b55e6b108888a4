"""The prose of all rooms and pages is plain; CONTRIBUTING has the rules.

Prose is docstrings, comments and the texts of errors and reports, and the
pages of docs/.
"""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "remosplat_drake"
ROOMS = sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py"))
PAGES = sorted(
    str(path.relative_to(ROOT / "docs")) for path in ROOT.glob("docs/**/*.md")
)

_FORBIDDEN = re.compile(
    r"\b(who|whom|whoever|nobody|somebody|anybody|whatever|lest|thereof)\b",
    re.IGNORECASE,
)
# Only people are "who".
_PEOPLE = re.compile(r"\b(person|people|operators?|readers?|users?) who\b")
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


def faults_of_module(source: str) -> list[str]:
    """Forbidden words in a module, and a first line that is no statement."""
    tree = ast.parse(source)
    prose = {*docstrings(tree), *messages(tree), *comments(source)}
    faults = [
        f"{line}: {word}" for line, text in prose for word in forbidden(text)
    ]
    first = (ast.get_docstring(tree) or "").partition("\n")[0]
    if not first.endswith(".") or _QUESTION.match(first):
        faults.append(f"1: {first}")
    return sorted(faults)


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_is_in_plain_words(room):
    modules = [
        path
        for path in sorted((PACKAGE / room).rglob("*.py"))
        if "This file automatically generated" not in path.read_text()
    ]
    assert modules
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
