"""The package's sources, parsed once for all tests that read them."""

import ast
from functools import cache
from pathlib import Path

import remosplat_drake

PACKAGE = Path(remosplat_drake.__file__).parent


@cache
def parsed(path: Path) -> ast.Module:
    """The syntax tree of a Python file."""
    return ast.parse(path.read_text())


@cache
def modules() -> dict[str, ast.Module]:
    """The syntax trees of all modules, by their paths in the package."""
    return {
        path.relative_to(PACKAGE).as_posix(): parsed(path)
        for path in sorted(PACKAGE.rglob("*.py"))
    }


@cache
def nodes(module: str) -> tuple[ast.AST, ...]:
    """All nodes of a module's syntax tree."""
    return tuple(ast.walk(modules()[module]))
