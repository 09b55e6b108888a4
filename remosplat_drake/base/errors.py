"""Exceptions: every error that a user can cause is a `RemoSplatError`.

The command line prints a `RemoSplatError` as one line and exits with code 2.
Any other exception is a bug of this package, and is printed with its traceback.
"""

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path


class RemoSplatError(Exception):
    """Base class of all errors that a user can cause and correct.

    Example:
        >>> import remosplat_drake as rs
        >>> try:
        ...     rs.load_robot("fankie")
        ... except rs.RemoSplatError as error:
        ...     print("frankie" in str(error))
        True
    """


class FileError(RemoSplatError):
    """Raised if a file is missing, unreadable or of the wrong kind.

    Attributes:
        path: The file or folder.
        problem: Description of the problem, which follows the file's path in
            the message.
    """

    def __init__(self, path: str | Path, problem: str):
        self.path = Path(path)
        self.problem = problem
        super().__init__(f"{path}: {problem}")


class FieldError(RemoSplatError):
    """Raised if a field of a file, scenario or flag has an unusable value.

    Attributes:
        where: The file (with the line, if it is known), the command-line flag
            or the class that contains the field.
        field: Path of the field inside the file, such as `oracle.n_sigma`.
        problem: Description of the problem with the value.
    """

    def __init__(self, where: str, field: str, problem: str):
        self.where = where
        self.field = field
        self.problem = problem
        super().__init__(f"{where}: {field}: {problem}")


class MissingExtraError(RemoSplatError):
    """Raised if a package of an optional extra is not installed."""

    def __init__(self, feature: str, extra: str):
        super().__init__(
            f"{feature} needs an optional extra: "
            f"pip install 'remosplat-drake[{extra}]'"
        )


_MANY, _LISTED = 12, 5
"""Two numbers. An error lists all valid names if there are at most as many as
the first number; otherwise, it lists as many as the second."""


def unknown_name(kind: str, name: object, valid: Iterable[str]) -> str:
    """Returns an error's text about an unknown name, with valid names.

    If there are many valid names, only the most similar ones are listed.

    Args:
        kind: The kind of thing that has the name, such as "robot".
        name: The name that was given.
        valid: The valid names.

    Returns:
        One line such as "unknown robot 'franky' (did you mean 'frankie'?);
        valid: ...".
    """
    names = sorted(valid)
    by_key = {n.casefold(): n for n in names}
    given = str(name).casefold()
    close = get_close_matches(given, by_key, n=1)
    guess = f" (did you mean {by_key[close[0]]!r}?)" if close else ""
    listed = ", ".join(names)
    if len(names) > _MANY:
        nearest = get_close_matches(given, by_key, n=_LISTED, cutoff=0.0)
        listed = ", ".join(by_key[key] for key in nearest)
        listed += f" and {len(names) - _LISTED} others"
    return f"unknown {kind} {name!r}{guess}; valid: {listed}"
