"""The runs of a session, each in a folder of its own: runs/0001 and on."""

from pathlib import Path

from remosplat_drake.base.errors import FieldError, FileError

RUNS = "runs"


def new_run(session: Path) -> Path:
    """Makes the folder of the next run of a session.

    Raises:
        FileError: It cannot be made.
    """
    number = max(run_numbers(session), default=0) + 1
    folder = session / RUNS / f"{number:04d}"
    try:
        folder.mkdir(parents=True)
    except OSError as error:
        raise FileError(folder, error.strerror or str(error)) from error
    return folder


def find_run(session: Path, number: int | None = None) -> Path:
    """The folder of a run; of the last one if no number is given.

    Raises:
        FileError: The session has no runs.
        FieldError: It has no such run; names those that it has.
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
    """The numbers of a session's runs, in order."""
    names = (path.name for path in session.glob(f"{RUNS}/*/"))
    return sorted(int(name) for name in names if name.isdecimal())
