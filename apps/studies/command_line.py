"""What the command lines of all studies share."""

import argparse
from collections.abc import Callable, Sequence

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
        name: Of the module in this folder.
        summary: What `--help` says of it: the module's docstring.
        add_arguments: Declares the flags.
        run: Runs the study and returns its exit code.
        argv: The flags; None takes those of this process.

    Returns:
        The exit code, as `remosplat` has it: 2 after one line on stderr that
        says what the user can mend.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m apps.studies.{name}", description=summary
    )
    add_arguments(parser)
    return exit_code(lambda: run(parser.parse_args(argv)))
