"""`KeptStages`: saves results of a job's stages, so that the job can resume.

The result of each finished stage is saved as a file in one folder. The file
contains a digest of the stage's inputs. A restarted job reuses the result only
if the digest is still the same. At the end of the job, the folder is removed.
"""

from collections.abc import Callable
from pathlib import Path
from shutil import rmtree
from types import TracebackType
from typing import Self, TypeVar

import numpy as np

from remosplat_drake.base.array_file import (
    FileKind,
    open_arrays,
    write_arrays,
)
from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.base.flat_values import digest, flatten, restore
from remosplat_drake.base.version import __version__

KIND = FileKind("finished stage", b"RSSTAGE\n", 1)

SUFFIX = ".stage"
"""File name extension of the stages' files."""

T = TypeVar("T")


class KeptStages:
    """A context manager around a job, which saves the job's finished stages.

    The folder of the stages is removed if the job succeeds, or if it ends in an
    error that the user must correct. It is kept if the job is interrupted.

    Example:
        >>> import dataclasses as dc
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> from remosplat_drake.base.kept_stages import KeptStages
        >>> @dc.dataclass
        ... class Sum:
        ...     total: int
        >>> with TemporaryDirectory() as folder:
        ...     with KeptStages(Path(folder) / "job", print) as stages:
        ...         a = stages.kept("sum", Sum, [1, 2], lambda: Sum(1 + 2))
        ...         b = stages.kept("sum", Sum, [1, 2], lambda: Sum(0))
        sum: reuses the kept result
        >>> a.total, b.total
        (3, 3)
    """

    def __init__(
        self,
        folder: Path | None,
        tell: Callable[[str], object] = lambda words: None,
    ):
        """Prepares the context manager, without reading a file.

        Args:
            folder: Folder of the stages' files, which need not exist. If it is
                None, no results are saved.
            tell: Function that is called with one line of text for each stage
                whose saved result is reused or cannot be reused.
        """
        self._folder, self._tell = folder, tell

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        is_over = kind is None or issubclass(kind, RemoSplatError)
        if is_over and self._folder is not None:
            rmtree(self._folder, ignore_errors=True)

    def kept(
        self, name: str, kind: type[T], inputs: object, make: Callable[[], T]
    ) -> T:
        """Returns a stage's saved result, or computes the result and saves it.

        Args:
            name: Name of the stage and of its file.
            kind: Dataclass of the result; its fields have types that
                `flat_values` accepts.
            inputs: All values that the result depends on, of types that
                `flat_values` accepts.
            make: Function that computes the result.

        Raises:
            FileError: The result cannot be written.
        """
        if self._folder is None:
            return make()
        path = self._folder / (name.replace(" ", "_") + SUFFIX)
        key = digest([__version__, name, inputs])
        try:
            result = _load(path, kind, key)
        except RemoSplatError as problem:
            self._tell(f"{name}: computed again: {problem}")
            result = None
        if result is not None:
            self._tell(f"{name}: reuses the kept result")
            return result
        text, arrays = flatten(make())
        arrays = {n: np.ascontiguousarray(a) for n, a in arrays.items()}
        write_arrays(path, KIND, {"key": key, "value": text}, arrays)
        # The result is rebuilt from its saved form, so that the arrays have the
        # same memory layout as in a resumed job. In another layout, sums over
        # an array might differ in the last bit.
        return restore(kind, text, arrays)


NOTHING_KEPT = KeptStages(None)
"""A `KeptStages` that saves no results."""


def _load(path: Path, kind: type[T], key: str) -> T | None:
    """Returns the result from a stage's file; None if there is no file.

    Raises:
        RemoSplatError: The file is damaged, or belongs to another job.
    """
    if not path.exists():
        return None
    file = open_arrays(path, KIND, None)
    if file.document.text("key") != key:
        raise FileError(path, "was made from other input or with other flags")
    arrays = {name: file.array(name) for name in file.names()}
    try:
        return restore(kind, file.document.text("value"), arrays)
    except (LookupError, TypeError, ValueError) as error:
        raise FileError(path, "was made by another version") from error
