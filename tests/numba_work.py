"""Compilations by numba in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

from numba.core import event


class NumbaWork(event.Listener):
    """Counts from now on how often numba loads or compiles something."""

    def __init__(self):
        self.total = 0
        event.register("numba:compiler_lock", self)

    def on_start(self, event):
        self.total += 1

    def on_end(self, event):
        pass


def printed_number(script: str, *arguments: str, **environment: str) -> int:
    """Runs a script, and returns the number that it prints.

    Args:
        script: The script, which finds what lies in folders of tests.
        arguments: Its arguments.
        environment: Variables that are set for it.
    """
    here = Path(__file__).parent
    path = os.pathsep.join([str(here), str(here / "detection")])
    result = subprocess.run(
        [sys.executable, "-c", script, *arguments],
        env=os.environ | {"PYTHONPATH": path} | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return int(result.stdout)
