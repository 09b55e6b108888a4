"""A tick is defined once: it fails if one of its functions raises.

These are the functions of the ingredients, of the decision and of verification,
in ticks of simulation, of a robot that obeys late, and of rollouts.

A compiled kernel ignores what is replaced in Python. Numba can be told not to
compile when a process starts: then the same functions run as Python. So the
ticks run in a process of their own.
"""

import os
import subprocess
import sys
from itertools import product
from pathlib import Path

from remosplat_drake.controller import ingredients
from remosplat_drake.controller.ingredients.kernels.assemble import PARTS

TICKS = Path(__file__).with_name("planted_ticks.py")
LAWS = "active set", "Clarabel", "outside", "compiled"
RUNS = "tick", "late tick", "rollout"
KINDS = [kind.__name__ for kind in PARTS]


def test_every_tick_runs_the_functions_that_define_it():
    done = subprocess.run(
        [sys.executable, str(TICKS)],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    planted = *KINDS, "decision", "verification", "objections"
    assert done.stdout.splitlines() == [
        f"{law}, {run}: {raised}"
        for law, run in product(LAWS, RUNS)
        for raised in ("nothing", *planted)
    ]


def test_no_ingredient_has_a_second_definition():
    names = {n for n in ingredients.__all__ if not n.endswith("Config")}
    assert names == set(KINDS)
    for kind in PARTS:
        assert not hasattr(kind, "AddToProgram")
