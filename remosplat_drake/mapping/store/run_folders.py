"""The folders of a session's runs: runs/0001, runs/0002, ..."""

from pathlib import Path

from remosplat_drake.base.errors import FieldError, FileError

RUNS = "runs"
"""Name of the folder of all runs in the session's folder."""


def new_run(session: Path) -> Path:
    """Makes the folder of the next run of a session, and returns it.

    Args:
        session: Folder of the session.

    Raises:
        FileError: The folder cannot be made.
    """
    number = max(run_numbers(session), default=0) + 1
    folder = session / RUNS / f"{number:04d}"
    try:
        folder.mkdir(parents=True)
    except OSError as error:
        raise FileError(folder, error.strerror or str(error)) from error
    return folder


def find_run(session: Path, number: int | None = None) -> Path:
    """Finds the folder of a run.

    Args:
        session: Folder of the session.
        number: Number of the run; None finds the last one.

    Raises:
        FileError: The session has no runs.
        FieldError: The session has no such run; the error lists the existing
            runs.
    """
    numbers = run_numbers(session)
    if not numbers:
        raise FileError(session, "holds no recorded runs")
    if number is None:
        number = numbers[-1]
    if number not in numbers:
        valid = ", ".join(map(str, numbers))
        raise FieldError(str(session), "run", f"no {number}; valid: {valid}")
    return session / RUNS / f"{number:04d}"


def run_numbers(session: Path) -> list[int]:
    """Lists the numbers of a session's runs, ascending."""
    names = (path.name for path in session.glob(f"{RUNS}/*/"))
    return sorted(int(name) for name in names if name.isdecimal())
