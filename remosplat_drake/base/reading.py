"""Adds the file's name to unexpected errors of file readers.

A reader, a function that reads a file, reports a problem of the file as a
`RemoSplatError`. Any other exception is a bug of this package, but the user
still needs the name of the file. The command line prints one line with this
name, and writes the traceback to a log. A program that calls the reader gets an
exception with both.

The decorator is meant for functions that read whole files before a robot moves.
Do not use it for code that runs while a robot moves, whose callers handle
specific exceptions.
"""

import functools
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar

from remosplat_drake.base.errors import RemoSplatError

P = ParamSpec("P")
T = TypeVar("T")


class UnreadableError(Exception):
    """Raised if a reader has failed with an unexpected error.

    It is not a `RemoSplatError`, since the file may be valid.

    Attributes:
        path: The file or folder that was read.
    """

    def __init__(self, path: str | Path, error: Exception):
        self.path = path
        what = f"{type(error).__name__}: {error}".removesuffix(": ")
        super().__init__(f"could not read {path}: {what}")


def reads_file(read: Callable[P, T]) -> Callable[P, T]:
    """Decorates a reader so that unexpected errors name the file.

    The decorated function raises an `UnreadableError` in place of any exception
    that is not a `RemoSplatError`.

    Args:
        read: A function whose first argument is the file or folder.
    """

    @functools.wraps(read)
    def guarded(*arguments: P.args, **named: P.kwargs) -> T:
        try:
            return read(*arguments, **named)
        except (RemoSplatError, UnreadableError, MemoryError):
            raise
        except Exception as error:
            path = next(iter((*arguments, *named.values())), "its file")
            raise UnreadableError(str(path), error) from error

    return guarded
