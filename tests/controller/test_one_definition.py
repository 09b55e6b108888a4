"""An ingredient is one function: a tick fails if that function raises.

A compiled kernel ignores what is replaced in Python. Numba can be told not to
compile when a process starts: then the same functions run as Python. So the
ticks run in a process of their own.
"""

import os
import subprocess
import sys
from pathlib import Path

from remosplat_drake.controller import ingredients
from remosplat_drake.controller.kernels.assemble import PARTS

TICKS = Path(__file__).with_name("planted_ticks.py")
LAWS = "in one call", "by steps", "with one from outside"
KINDS = [kind.__name__ for kind in PARTS]


def test_each_ingredient_runs_the_function_that_defines_it():
    done = subprocess.run(
        [sys.executable, str(TICKS)],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    assert done.stdout.splitlines() == [
        f"{law}: {raised}" for law in LAWS for raised in ("nothing", *KINDS)
    ]


def test_no_ingredient_has_a_second_definition():
    names = {n for n in ingredients.__all__ if not n.endswith("Config")}
    assert names == set(KINDS)
    for kind in PARTS:
        assert not hasattr(kind, "AddToProgram")
