"""Kernels that other processes compile."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

KERNELS = """
import os
import numpy as np
from numba import types
from remosplat_drake.base.kernels import compilation, kernel

@kernel(returns=types.float64)
def least(x):
    return x.min()

@kernel(returns=types.float64)
def greatest(x):
    return x.max()

@kernel
def mean(x):
    return x.mean()

@kernel
def all_of(x):
    return least(x), greatest(x), mean(x)
"""

PROGRAM = """
import kernels_of_mine as mine
import numpy as np
from remosplat_drake.base.kernels import compilation, variant
mine.all_of({0})
count = compilation.count()
kept = [v.kernel.__name__ for v in variant.variants if v.was_kept]
print(count.done, count.total, "greatest" in kept, "mean" in kept)
"""


def printed(
    folder: Path,
    program: str = PROGRAM.format("np.ones(3)"),
    **environment: str,
) -> list[str]:
    (folder / "kernels_of_mine.py").write_text(KERNELS)
    result = subprocess.run(
        [sys.executable, "-c", program],
        cwd=folder,
        env=os.environ
        | {"NUMBA_CACHE_DIR": str(folder / "kernels")}
        | environment,
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.split()


def test_kernels_that_say_what_they_return_may_be_compiled_beside(tmp_path):
    *counts, _, mean = printed(tmp_path, REMOSPLAT_COMPILERS="1")
    assert counts == ["4", "4"]
    assert mean == "False"  # Its caller needs to know what it returns.


@pytest.mark.slow
def test_one_process_is_enough(tmp_path):
    answer = printed(tmp_path, REMOSPLAT_COMPILERS="0")
    assert answer == ["4", "4", "False", "False"]


EXPECTED = """
import kernels_of_mine as mine
import numpy as np
from numba import float64
from remosplat_drake.base.kernels import compilation
kernels = mine.all_of, mine.greatest, mine.least
variants = {k.variant((float64[::1],)): 1.0 for k in kernels}
compilation.expect(lambda: variants)
mine.mean(np.ones(3))
while compilation.count().done < 4:
    with compilation._state.changed:
        compilation._state.changed.wait(1.0)
print(*(int(variant.is_kept) for variant in variants))
"""


@pytest.mark.slow
def test_what_is_expected_is_compiled_by_others(tmp_path):
    answer = printed(tmp_path, EXPECTED, REMOSPLAT_COMPILERS="2")
    assert answer == ["1", "1", "1"]


KILLED = """
import kernels_of_mine as mine
import numpy as np
import subprocess
from remosplat_drake.base.kernels import compilation
start = subprocess.Popen.__init__
def start_and_kill(self, *arguments, **options):
    start(self, *arguments, **options)
    self.kill()
subprocess.Popen.__init__ = start_and_kill
print(*mine.all_of(np.ones(3)))
"""


def test_without_the_others_this_process_compiles_all(tmp_path):
    answer = printed(tmp_path, KILLED, REMOSPLAT_COMPILERS="1")
    assert answer == ["1.0", "1.0", "1.0"]


FAILING = """
import numpy as np
from numba import types
from remosplat_drake.base.kernels import kernel

@kernel(returns=types.float64)
def wrong(x):
    return x.nothing()

@kernel
def calls(x):
    return wrong(x)
"""


@pytest.mark.parametrize(
    "compilers", ["0", pytest.param("1", marks=pytest.mark.slow)]
)
def test_what_fails_elsewhere_fails_here_and_says_why(tmp_path, compilers):
    (tmp_path / "failing.py").write_text(FAILING)
    program = """
import failing, numpy as np
from numba.core.errors import TypingError
for _ in range(2):
    try:
        failing.calls(np.ones(3))
    except TypingError as error:
        print("nothing" in str(error))
"""
    answer = printed(tmp_path, program, REMOSPLAT_COMPILERS=compilers)
    assert answer == ["True", "True"]
