"""Expands xacro files to URDF, and lists their arguments."""

import contextlib
import dataclasses as dc
import importlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from remosplat_drake.base.errors import (
    FieldError,
    FileError,
    RemoSplatError,
    unknown_name,
)
from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.robot.importing.findings import Findings, listed
from remosplat_drake.robot.importing.packages import Packages

_ARGUMENT = re.compile(r"<(?:xacro:)?arg\s([^>]*)>")
_USED = re.compile(r"\$\(arg (\w+)\)")
_ATTRIBUTE = re.compile(r"""(\w+)\s*=\s*(?:"([^"]*)"|'([^']*)')""")
_PROPERTY = re.compile(
    r"""name=["'](\w+)["']\s+value=["']\$\(arg (\w+)\)["']"""
)
_INCLUDE = re.compile(r"""<xacro:include\s+filename=["']([^"']+)["']""")
_FIND = re.compile(r"\$\(find ([\w-]+)\)")
_HOLE = re.compile(r"\$\{\s*(\w+)\s*\}|\$\(arg (\w+)\)")

_UNDEFINED = re.compile(r"Undefined substitution argument (\w+)")
"""Xacro's error about a missing argument without a default."""


@dc.dataclass(frozen=True)
class XacroArgument:
    """An argument that a xacro file declares.

    Attributes:
        name: Name of the argument.
        default: Default value; None if the argument is required.
        choices: Values of the argument that the files distinguish; empty if
            they distinguish none.
    """

    name: str
    default: str | None
    choices: tuple[str, ...]

    def __str__(self) -> str:
        said = self.name
        said += " (needed" if self.default is None else f" ({self.default!r}"
        if self.choices:
            said += f"; of {', '.join(self.choices)}"
        return f"{said})"


def expand_xacro(
    path: Path,
    packages: Packages,
    given: dict[str, str],
    findings: Findings,
) -> str:
    """Expands a xacro file to the text of a URDF.

    Args:
        path: The file.
        packages: Resolves references to ROS packages.
        given: Values of its arguments by name.
        findings: Receives the arguments of the file.

    Raises:
        RemoSplatError: A file is missing or broken, or an argument is unknown
            or missing; the text names all arguments.
        MissingExtraError: Xacro is not installed.
    """
    xacro = import_optional("xacro", "reading xacro", "robots")
    arguments = xacro_arguments(path, packages)
    for name in given:
        if name not in arguments:
            problem = unknown_name("argument", name, arguments)
            raise FieldError(str(path), "--arg", problem)
    with _packages_of(packages):
        try:
            document = xacro.process_file(str(path), mappings=dict(given))
        # A xacro file may contain Python, so any exception is possible.
        except Exception as error:
            raise _told(path, error, arguments) from error
    if arguments:
        texts = [str(argument) for argument in arguments.values()]
        findings.find("xacro arguments", f"{listed(texts)}; --arg sets them")
    return document.toxml()


def xacro_arguments(path: Path, packages: Packages) -> dict[str, XacroArgument]:
    """Finds the arguments of a xacro file, and of the files that it includes.

    Args:
        path: The file.
        packages: Resolves references to ROS packages.
    """
    texts = dict(_included(path, packages, set()))
    defaults: dict[str, str | None] = {}
    for text in texts.values():
        for declared in _ARGUMENT.findall(text):
            found = {k: a or b for k, a, b in _ATTRIBUTE.findall(declared)}
            if "name" in found and defaults.get(found["name"]) is None:
                defaults[found["name"]] = found.get("default")
    for text in texts.values():
        for name in _USED.findall(text):
            defaults.setdefault(name)
    return {
        name: XacroArgument(name, default, _choices(name, texts, packages))
        for name, default in defaults.items()
    }


def _included(
    path: Path, packages: Packages, seen: set[Path]
) -> Iterator[tuple[Path, str]]:
    """Returns a file and its includes without placeholders, with texts."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError):
        return
    seen.add(path)
    yield path, re.sub("<!--.*?-->", "", text, flags=re.DOTALL)
    for name in _INCLUDE.findall(text):
        with contextlib.suppress(FieldError):
            file = _place(name, path, packages)
            if file not in seen and not _HOLE.search(name):
                yield from _included(file, packages, seen)


def _place(name: str, path: Path, packages: Packages) -> Path:
    """Returns the file of an <xacro:include>."""
    package = _FIND.match(name)
    if package is None:
        return path.parent / name
    rest = name[package.end() :].lstrip("/")
    return packages.folder(package[1], name, (rest,)) / rest


def _choices(
    argument: str, texts: dict[Path, str], packages: Packages
) -> tuple[str, ...]:
    """Returns an argument's values that conditions or file names contain."""
    names, choices = {argument}, set()
    for text in texts.values():
        names |= {x for x, given in _PROPERTY.findall(text) if given in names}
    for path, text in texts.items():
        for name in names:
            compared = rf"\b{name}\s*==\s*(?:&quot;|['\"])?([\w.-]+)"
            choices |= set(re.findall(compared, text))
        for include in _INCLUDE.findall(text):
            choices |= _files_for(include, names, path, packages)
    return tuple(sorted(choices))


def _files_for(
    include: str, names: set[str], path: Path, packages: Packages
) -> set[str]:
    """Returns candidate values of an include's first placeholder."""
    hole = _HOLE.search(_FIND.sub("", include))
    if hole is None or not {hole[1], hole[2]} & names:
        return set()
    before, after = include.split(hole[0], 1)
    if not before:
        return set()
    try:
        place = _place(f"{before}*", path, packages)
    except FieldError:
        return set()
    ending = after.partition("/")[0]
    start = place.name[:-1]
    return {
        found.name[len(start) : len(found.name) - len(ending)]
        for found in place.parent.glob(f"{start}*{ending}")
        if not _HOLE.search(ending)
    }


def _told(
    path: Path, error: Exception, arguments: dict[str, XacroArgument]
) -> RemoSplatError:
    """Returns the error that describes xacro's failure."""
    for cause in _causes(error):
        if isinstance(cause, RemoSplatError):
            return cause
    problem = " ".join(str(error).split()) or type(error).__name__
    missing = _UNDEFINED.search(problem)
    if missing:
        texts = [str(argument) for argument in arguments.values()]
        return FieldError(
            str(path),
            f"argument {missing[1]!r}",
            f"has no default: give --arg {missing[1]}=...; arguments:"
            f" {listed(texts, 12)}",
        )
    return FileError(path, f"xacro: {problem}")


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    """Returns an error and the errors that caused it."""
    while error is not None:
        yield error
        wrapped = getattr(error, "exc", None)
        error = wrapped or error.__cause__ or error.__context__


@contextlib.contextmanager
def _packages_of(packages: Packages) -> Iterator[None]:
    """Resolves `$(find NAME)` with `packages`, not with a ROS installation."""
    module: Any = importlib.import_module("xacro.substitution_args")
    before = module._eval_find

    def found(name: str) -> str:
        # The files that are needed from a package identify its folder.
        with contextlib.suppress(OSError, UnicodeDecodeError):
            text = packages.file.read_text(encoding="utf-8-sig")
            wanted = re.escape(f"$(find {name})/")
            rests = re.findall(rf"{wanted}([\w./-]+)", text)
            return str(
                packages.folder(
                    name, f"$(find {name})", tuple(rests)
                ).absolute()
            )
        return str(packages.folder(name, f"$(find {name})").absolute())

    module._eval_find = found
    try:
        yield
    finally:
        module._eval_find = before
