"""The `remosplat` console script: finds the command and reports errors."""

import logging
import sys
from collections.abc import Callable, Sequence

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.base.reading import UnreadableError
from remosplat_drake.base.stop_signals import is_interrupt
from remosplat_drake.base.version import __version__
from remosplat_drake.commands.catalogue import COMMANDS, overview
from remosplat_drake.commands.command_parser import CommandParser
from remosplat_drake.commands.unexpected import one_line, report

USER_ERROR = 2


def main(argv: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code, see `exit_code`."""
    argv = list(sys.argv[1:] if argv is None else argv)

    return exit_code(lambda: _run(argv))


def exit_code(run: Callable[[], int]) -> int:
    """Reads and runs a command line, and returns its exit code.

    Returns:
        0: success. 1: the command ran without success, for example because the
            robot did not reach its target. 2: an error, described by one line
            on stderr: the user can correct it, or a file could not be read
            because of a defect of the program; the line then names a log with
            the traceback. 130: Ctrl-C. Any other exception is a defect, and
            Python prints its traceback.
    """
    # This suppresses Drake's line about its web server, since the commands
    # print their own line. Drake reads this variable when it is imported, which
    # is later.
    logging.getLogger("drake").addFilter(_is_no_announcement)
    try:
        return run()
    except RemoSplatError as error:
        print(f"remosplat: {one_line(error)}", file=sys.stderr)
        return USER_ERROR
    except UnreadableError as error:
        report(error)
        return USER_ERROR
    except MemoryError as error:
        what = f": {one_line(error)}" if str(error) else ""
        print(f"remosplat: not enough memory{what}", file=sys.stderr)
        return USER_ERROR
    except (KeyboardInterrupt, SystemError) as error:
        if not is_interrupt(error):
            raise
        print("remosplat: interrupted", file=sys.stderr)
        return 130


def _is_no_announcement(record: logging.LogRecord) -> bool:
    return record.levelno >= logging.WARNING


def _run(argv: list[str]) -> int:
    """Handles --help and --version, or runs a command."""
    if not argv:
        print(overview(), end="", file=sys.stderr)
        return USER_ERROR
    command, *rest = argv
    if command in ("--help", "-h"):
        print(overview(), end="")
        return 0
    if command == "--version":
        print(__version__)
        return 0
    if command.startswith("-"):
        raise RemoSplatError(
            f"{command}: a flag precedes the command; give the command's name "
            "before its flags"
        )
    if command not in COMMANDS:
        raise RemoSplatError(unknown_name("command", command, COMMANDS))
    arguments = CommandParser(command).parse_args(rest)
    return arguments.run(arguments)
