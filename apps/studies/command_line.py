"""Common code of the command lines of all studies."""

import argparse
import os
from collections.abc import Callable, Sequence
from pathlib import Path

from remosplat_drake.base.atomic_file import check_writable
from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.commands.main import exit_code


def study_main(
    name: str,
    summary: str | None,
    add_arguments: Callable[[argparse.ArgumentParser], None],
    run: Callable[[argparse.Namespace], int],
    argv: Sequence[str] | None = None,
) -> int:
    """Runs a study from its command line.

    Args:
        name: Name of the study's module in this folder.
        summary: Description that `--help` prints: the module's docstring.
        add_arguments: Function that declares the flags.
        run: Function that runs the study and returns its exit code.
        argv: Command-line arguments; None takes those of this process.

    Returns:
        The exit code, like that of `remosplat`: 2 after one line on stderr with
        the error that the user can correct.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m apps.studies.{name}", description=summary
    )
    add_arguments(parser)
    return exit_code(lambda: run(parser.parse_args(argv)))


def add_count_flag(
    parser: argparse.ArgumentParser, flag: str, default: int, meaning: str
) -> None:
    """Declares a flag that takes a whole number.

    Args:
        parser: Parser that receives the flag.
        flag: Name of the flag, without dashes.
        default: Its default.
        meaning: Its meaning, for the help.
    """
    parser.add_argument(
        f"--{flag}",
        type=int,
        default=default,
        metavar="N",
        help=f"{meaning} ({default})",
    )


def add_trial_flags(
    parser: argparse.ArgumentParser, study: str, count: int, trials: str
) -> None:
    """Declares the flags of a study of numbered trials, whose results are kept.

    They are `--first`, `--count`, `--jobs` and `--output`.

    Args:
        parser: Parser that receives the flags.
        study: Name of the study's module in this folder.
        count: Default number of trials.
        trials: The trials in words, for the help.
    """
    add_count_flag(parser, "first", 0, "number, or seed, of the first one")
    add_count_flag(parser, "count", count, f"number of {trials}")
    add_count_flag(parser, "jobs", 2, "number of parallel workers")
    add_output_flag(
        parser,
        study,
        "folder of the results; existing results are not computed again",
    )


def add_output_flag(
    parser: argparse.ArgumentParser, study: str, meaning: str
) -> None:
    """Declares the flag `--output` with the folder of a study's results.

    Args:
        parser: Parser that receives the flag.
        study: Name of a folder in `results/`, the default.
        meaning: The folder's contents, for the help.
    """
    output = Path("results") / study
    parser.add_argument(
        "--output",
        type=output_folder,
        # A text, so that the default is checked by `type`, too.
        default=str(output),
        metavar="DIR",
        help=f"{meaning} ({output})",
    )


def output_folder(text: str) -> Path:
    """Makes the folder that a flag names, unless it exists.

    Args:
        text: The flag's value.

    Raises:
        FileError: The folder cannot be made or written.
    """
    path = Path(text)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        problem = f"cannot be made: {error.strerror or error}"
        raise FileError(path, problem) from error
    if not os.access(path, os.W_OK | os.X_OK):
        raise FileError(path, "cannot be written")
    return path


def output_file(text: str) -> Path:
    """Checks that the file that a flag names can be written.

    Args:
        text: The flag's value.

    Raises:
        FileError: The file cannot be written.
    """
    path = Path(text)
    check_writable(path)
    return path


def check_least(
    study: str, arguments: argparse.Namespace, **least: int
) -> None:
    """Checks flags with whole numbers against their lower bounds.

    Args:
        study: Name of the study, which an error names.
        arguments: The parsed command line.
        **least: The least value of each flag, by the flag's name.

    Raises:
        FieldError: A value is too small.
    """
    for name, bound in least.items():
        if getattr(arguments, name) < bound:
            raise FieldError(study, f"--{name}", f"must be at least {bound}")
