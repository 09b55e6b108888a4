"""`TerminalLines`: what a person types while a program does something else."""

import os
import select
import sys


class TerminalLines:
    """The lines that are typed at this process's terminal, if it has one."""

    def __init__(self):
        """Looks for a terminal; nothing is read yet."""
        self._open = sys.stdin is not None and sys.stdin.isatty()

    @property
    def is_open(self) -> bool:
        """Whether somebody could type something."""
        return self._open

    def fetch(self) -> str | None:
        """Returns a line that was typed since the last call; None if none was.

        It never waits. In the background, what is typed is not for us.
        """
        if not self._open:
            return None
        number = sys.stdin.fileno()
        if not _is_in_foreground(number):
            return None
        if not select.select([number], [], [], 0)[0]:
            return None
        # Not by readline: its buffer would hide a second line from `select`.
        data = os.read(number, 4096)
        self._open = bool(data)
        return data.decode(errors="replace").strip() if data else None


def _is_in_foreground(number: int) -> bool:
    """Whether we may read; a terminal that controls nobody stops nobody."""
    try:
        return os.tcgetpgrp(number) == os.getpgrp()
    except OSError:
        return True
