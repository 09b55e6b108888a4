"""The content by which kernels are distinguished and compiled again."""

import enum
import gc
import os
import re
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import CodeType, FunctionType

import numpy as np
import pytest

import remosplat_drake
from remosplat_drake.base.kernels import helper, kernel, overload
from remosplat_drake.base.kernels.content import (
    UnknownContentError,
    content_digest,
)
from remosplat_drake.base.kernels.files import kernels_dir
from remosplat_drake.base.kernels.kernel import Kernel

PACKAGE = Path(remosplat_drake.__file__).parent


def made(text: str, **names) -> FunctionType:
    """The function f of a source."""
    space = {"__name__": "mine", "helper": helper, "kernel": kernel, **names}
    exec(text, space)
    return space["f"]


BASE = """
LIMIT = 3.0
TABLE = (1, 2)
def g(x, by=2):
    return by * x
def f(x):
    return g(x) + LIMIT + TABLE[0]
"""


def test_equal_sources_are_equal_wherever_they_lie():
    moved = "\n\n# A comment.\n" + BASE
    assert content_digest(made(BASE)) == content_digest(made(moved))


def test_words_count_for_nothing():
    said = BASE.replace("def f(x):\n", 'def f(x):\n    """Says more."""\n')
    more = said.replace("more", "even more")
    assert content_digest(made(said)) == content_digest(made(more))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("3.0", "3.5"),
        ("3.0", "3"),
        ("(1, 2)", "(1, 3)"),
        ("by * x", "by + x"),
        ("by=2", "by=3"),
        ("g(x) +", "g(x) -"),
    ],
)
def test_each_edit_counts(old, new):
    changed = BASE.replace(old, new)
    assert changed != BASE
    assert content_digest(made(BASE)) != content_digest(made(changed))


def test_closures_arrays_and_loops_of_functions_are_told():
    def closure(value):
        def f(x):
            return x + value

        return f

    assert content_digest(closure(1)) != content_digest(closure(2))
    arrays = [made("def f(x): return A[x]", A=np.array([1.0, k])) for k in "12"]
    assert content_digest(arrays[0]) != content_digest(arrays[1])
    recursive = "def f(x): return f(x - 1) if x else {}"
    assert content_digest(made(recursive.format(0))) != content_digest(
        made(recursive.format(1))
    )


def test_the_forms_of_an_overload_count():
    def f(x):
        raise NotImplementedError

    before = content_digest(f)

    @overload(f)
    def _f(x):
        return lambda x: x + 1

    assert content_digest(f) != before


def test_of_kernels_that_are_called_by_address_only_the_name_counts():
    text = "@kernel\ndef g(x): return x + 1\ndef f(x): return g(x)"
    other = text.replace("+ 1", "+ 2")
    assert content_digest(made(text)) == content_digest(made(other))
    linked = text.replace("@kernel", "@kernel(linked=True)")
    other = other.replace("@kernel", "@kernel(linked=True)")
    assert content_digest(made(linked)) != content_digest(made(other))


def test_members_of_enumerations_count():
    def member(**members):
        kind = enum.Enum("Kind", members)
        return made("def f(x): return x == K.A", K=kind)

    assert content_digest(member(A=1, B=2)) != content_digest(member(A=2, B=1))


def test_modules_of_the_package_are_not_known_by_their_names():
    """What a kernel reads of one would be missing."""
    with pytest.raises(UnknownContentError):
        content_digest(made("def f(x): return x + M.A", M=remosplat_drake))
    assert content_digest(made("def f(x): return M.sqrt(x)", M=np))


def test_what_cannot_be_told_is_not_kept():
    with pytest.raises(UnknownContentError):
        content_digest(made("def f(x): return x + A", A=object()))
    untold = kernel(made("def f(x): return x + A[0]", A=[1, object()]))
    assert not untold.digest


def test_the_content_of_all_kernels_of_the_package_can_be_told():
    for path in PACKAGE.rglob("*.py"):
        if re.search("base.kernels import", path.read_text()):
            parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
            import_module(".".join(parts))
    gc.unfreeze()  # Those of modules that were imported before, too.
    kernels = [
        found
        for found in gc.get_objects()
        if isinstance(found, Kernel)
        and found.__module__.startswith("remosplat_drake")
    ]
    gc.freeze()
    assert len(kernels) > 100
    for found in kernels:
        assert content_digest(found.py_func)


def test_bytecode_has_no_further_parts():
    """If this fails, a new Python's code holds something more."""
    known = "argcount code consts freevars cellvars filename firstlineno flags"
    known += " lines linetable lnotab name names nlocals posonlyargcount"
    known += " kwonlyargcount positions qualname stacksize varnames"
    known += " exceptiontable branches"
    parts = {name for name in dir(CodeType) if name.startswith("co_")}
    assert parts <= {f"co_{name}" for name in known.split()}


class Checkout:
    """A copy of the package, whose kernels Python processes use."""

    def __init__(self, folder: Path):
        self.folder = folder
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(PACKAGE, folder / PACKAGE.name, ignore=ignored)
        for name in ("models", "scenarios"):
            (folder / name).symlink_to(PACKAGE.parent / name)

    def edit(self, file: str, old: str, new: str) -> None:
        """Replaces a text by another one, and leaves the file as old."""
        path = self.folder / PACKAGE.name / file
        before, text = path.stat(), path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns + 1))

    def started(self, program: str, kernels: str = "kernels"):
        """Returns a process that has imported a kernel and waits.

        It writes no bytecode, since Python recognizes an edit by the time.
        """
        process = subprocess.Popen(
            [sys.executable, "-c", program],
            cwd=self.folder,
            env=os.environ
            | {
                "PYTHONPATH": str(self.folder),
                "PYTHONDONTWRITEBYTECODE": "1",
                "NUMBA_CACHE_DIR": str(self.folder / kernels),
            },
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        return process

    def answers(self, program: str, kernels: str = "kernels") -> list[str]:
        """Returns the words that a process of its own prints."""
        return told(self.started(program, kernels))


def told(process: subprocess.Popen) -> list[str]:
    """Returns the words that a process prints, which goes on now."""
    output, _ = process.communicate("\n")
    assert process.returncode == 0
    return output.split()


CHAIN = """
import numpy as np
from remosplat_drake.controller.verification.kernels.places import chain
print("ready", flush=True)
input()
starts = chain(np.zeros(1), np.ones((2, 1)), np.ones(2), 0)
print(starts[1, 0], chain.variants[0].was_kept)
"""
FORWARDS = "robot/kinematics.py", "[first + k] += u", "[first + k] -= u"
"""An edit of code of another file that it contains, after which it is -1."""


@pytest.fixture
def checkout(tmp_path) -> Checkout:
    return Checkout(tmp_path / "checkout")


def test_code_of_other_files_counts_and_comments_do_not(checkout):
    assert checkout.answers(CHAIN) == ["1.0", "False"]
    checkout.edit("robot/kinematics.py", "Args:", "Arguments:")
    assert checkout.answers(CHAIN) == ["1.0", "True"]
    checkout.edit(*FORWARDS)
    assert checkout.answers(CHAIN) == ["-1.0", "False"]
    checkout.edit(FORWARDS[0], FORWARDS[2], FORWARDS[1])
    assert checkout.answers(CHAIN) == ["1.0", "True"]


@pytest.mark.slow
def test_each_process_finds_the_kernels_of_the_code_that_it_runs(checkout):
    old = checkout.started(CHAIN)
    checkout.edit(*FORWARDS)
    assert checkout.answers(CHAIN) == ["-1.0", "False"]
    assert told(old) == ["1.0", "False"]
    assert checkout.answers(CHAIN) == ["-1.0", "True"]


MINE = """
import numpy as np
from numba import njit
from remosplat_drake.robot.kinematics import advance_for

@njit(cache=True)
def mine(q):
    return advance_for(q, np.ones(1), 0, np.ones(1))[0, 0]

print("ready", flush=True)
input()
print(mine(np.zeros(1)), sum(mine.stats.cache_hits.values()))
"""


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Cannot cache")
def test_functions_that_numba_keeps_are_compiled_anew(checkout):
    """Numba would keep them beyond the kernels that they call."""
    (checkout.folder / "mine.py").write_text(MINE)
    assert checkout.answers("import mine") == ["1.0", "0"]
    assert checkout.answers("import mine") == ["1.0", "0"]
    checkout.edit(*FORWARDS)
    assert checkout.answers("import mine") == ["-1.0", "0"]


TICK = """
import numpy as np
from remosplat_drake.app.scenario import DEFAULT_SCENARIO, load_scenario
from remosplat_drake.app.warm_up import compile_kernels
from remosplat_drake.app.world import load_world
from remosplat_drake.base.kernels import variant
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
text = "{controller: {guidance: {enabled: false}}}"
scenario = load_scenario(DEFAULT_SCENARIO, text)
world = load_world(scenario)
print("ready", flush=True)
input()
robot, q = world.robot, world.q0
law = ReactiveLaw.make(scenario.controller, robot, scenario.control_period)
X_WT = robot.end_effector_pose(q)
X_WT[:3, 3] += 0.1
rows = world.field.clearances(robot.state(q).spheres, 0.5)
report = run_tick(law, 0.0, q, X_WT, rows, world.field, np.zeros(robot.n_u))
print(*report.command)
called = [v for v in variant.variants if v.kernel.content]
print(*sorted(v.file for v in called if v.uses is not None))
"""


@pytest.mark.slow
def test_an_edited_ingredient_is_compiled_alone_and_runs(checkout):
    """The tick as Python calls it, in which no command was run before."""
    path = "controller/ingredients/velocity_cost.py"
    text = (PACKAGE / path).read_text()
    line = next(
        line for line in text.splitlines() if "program.quadratic" in line
    )
    old, files = told_tick(checkout)
    assert told_tick(checkout) == (old, files)
    checkout.edit(path, line, line.replace("=", "= 100.0 *", 1))
    new, others = told_tick(checkout)
    (fresh,) = set(others) - set(files)
    assert fresh.startswith("add_velocity_cost-")
    assert not np.allclose(new, old)


def told_tick(checkout: Checkout) -> tuple[list[float], list[str]]:
    """The command of a tick, and the files of its kernels."""
    words = checkout.answers(TICK, str(kernels_dir()))
    numbers = [word for word in words if "kernel" not in word]
    return [float(word) for word in numbers], words[len(numbers) :]
