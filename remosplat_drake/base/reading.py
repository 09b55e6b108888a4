"""The last resort of readers: what a file must not have done, told apart.

A reader names what is wrong with a file in a `RemoSplatError`. Whatever else
it raises is a defect of ours; but the person at the keyboard has a file, and
wants to know which. The command line makes one line of it and keeps the
traceback in a log; a program or a test that calls the reader sees both.

Only what reads whole files before anything moves is marked. What happens
while a robot is driven keeps its own exceptions.
"""

import functools
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar

from remosplat_drake.base.errors import RemoSplatError

P = ParamSpec("P")
T = TypeVar("T")


class UnreadableError(Exception):
    """A reader has failed with an error that nobody has foreseen.

    It is no `RemoSplatError`: nothing may take it for an answer about the file.

    Attributes:
        path: The file or folder that was read.
    """

    def __init__(self, path: str | Path, error: Exception):
        self.path = path
        what = f"{type(error).__name__}: {error}".removesuffix(": ")
        super().__init__(f"could not read {path}: {what}")


def reads_file(read: Callable[P, T]) -> Callable[P, T]:
    """Decorates a reader so that unforeseen errors name the file.

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
