"""Adds the file's name to unexpected errors of file readers.

A reader reports a problem of a file as a `RemoSplatError`. Any other exception
is a bug of this package, but the user still needs the name of the file. The
command line prints one line and keeps the traceback in a log; a program or test
that calls the reader gets both.

The decorator is only for functions that read whole files before anything moves.
Code that runs while a robot moves keeps its own exceptions.
"""

import functools
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar

from remosplat_drake.base.errors import RemoSplatError

P = ParamSpec("P")
T = TypeVar("T")


class UnreadableError(Exception):
    """A reader has failed with an unexpected error.

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

    Any exception other than a `RemoSplatError` becomes an `UnreadableError`.

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
