"""Adds the name of the file to unexpected errors of functions that read files.

A reader is a function that reads a file. It reports a problem of the file as a
`RemoSplatError`. Any other exception is a bug of this package, but the user
still needs the name of the file. For such a bug, the command line prints one
line with this name, and writes the traceback to a log. A Python program that
calls the reader receives an `UnreadableError`, which has the name and the
traceback.

Use the decorator `reads_file` for functions that read whole files before a
robot moves. Do not use it for code that runs while a robot moves, since the
callers of such code handle specific exceptions.
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

    This error is not a `RemoSplatError`, since the file may be valid.

    Attributes:
        path: The file or folder that was read.
    """

    def __init__(self, path: str | Path, error: Exception):
        self.path = path
        what = f"{type(error).__name__}: {error}".removesuffix(": ")
        super().__init__(f"could not read {path}: {what}")


def reads_file(read: Callable[P, T]) -> Callable[P, T]:
    """Decorates a reader, so that its unexpected errors name the file.

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
