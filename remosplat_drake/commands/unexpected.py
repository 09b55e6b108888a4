"""Reports errors of file readers that are defects of the program."""

import hashlib
import os
import platform
import sys
import traceback
from pathlib import Path

from remosplat_drake.base import resources
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.reading import UnreadableError
from remosplat_drake.base.version import __version__

SHOW_TRACEBACK = "REMOSPLAT_TRACEBACK"
"""Name of an environment variable. If it is set, tracebacks are printed,
too."""

_LONGEST_LINE = 2000


def report(error: UnreadableError) -> None:
    """Prints one line, which names a log file with the traceback.

    If no log can be written, the traceback itself is printed.
    """
    text = "".join(traceback.format_exception(error))
    try:
        log = f"the traceback is in {_write_log(text)}"
    except RemoSplatError as problem:
        log = f"no log of the traceback could be written ({problem})"
        print(text, end="", file=sys.stderr)
    else:
        if os.environ.get(SHOW_TRACEBACK):
            print(text, end="", file=sys.stderr)
    line = one_line(error)
    print(f"remosplat: {line}; {log}; please report it", file=sys.stderr)


def one_line(error: Exception) -> str:
    """Returns an error's text as one printable line.

    This is needed, since names in files may contain line ends and control
    characters.
    """
    line = "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode()
        for c in str(error)
    )
    if len(line) > _LONGEST_LINE:
        line = line[:_LONGEST_LINE] + "..."
    return line


def _write_log(text: str) -> Path:
    """Writes a log and returns its path; equal tracebacks have the same path.

    The log contains versions and lines of the program, but no values of
    variables, no arguments of the command and no environment variables.
    """
    digest = hashlib.sha256(text.encode(errors="replace")).hexdigest()
    path = resources.state_dir() / "tracebacks" / f"{digest[:12]}.log"
    header = (
        f"remosplat-drake {__version__}, Python {platform.python_version()},"
        f" {platform.platform()}\n\n"
    )
    write_atomically(path, (header + text).encode(errors="replace"))
    return path
