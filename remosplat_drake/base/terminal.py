"""`TerminalLines`: reads lines that a user types while a program runs."""

import os
import select
import sys


class TerminalLines:
    """Reads the lines that a user types at this process' terminal."""

    def __init__(self):
        """Opens the terminal, without reading a line."""
        self._open = sys.stdin is not None and sys.stdin.isatty()

    @property
    def is_open(self) -> bool:
        """Whether there is a terminal to type at."""
        return self._open

    def fetch(self) -> str | None:
        """Returns a line typed since the last call; None if there is no line.

        The call does not wait for input. A background process gets no input.
        """
        if not self._open:
            return None
        number = sys.stdin.fileno()
        if not _is_in_foreground(number):
            return None
        if not select.select([number], [], [], 0)[0]:
            return None
        # `readline` is not used: its buffer would hide a second line from
        # `select`.
        data = os.read(number, 4096)
        self._open = bool(data)
        return data.decode(errors="replace").strip() if data else None


def _is_in_foreground(number: int) -> bool:
    """Whether this process may read its terminal without being suspended."""
    try:
        return os.tcgetpgrp(number) == os.getpgrp()
    except OSError:
        return True
