"""Compiled code does not outlive the sources that it was made of."""

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from remosplat_drake.base import kernel_sources

PACKAGE = Path(__file__).resolve().parents[2] / "remosplat_drake"

CHAIN = """
import numpy as np
from remosplat_drake.controller.verification.kernels.places import chain
print("ready", flush=True)
input()
starts = chain(np.zeros(1), np.ones((2, 1)), np.ones(2), 0)
print(starts[1, 0], sum(chain.stats.cache_hits.values()))
"""
"""Prints what a kernel answers, and how many of it were on disk."""

FORWARDS = "robot/kinematics.py", "[first + k] += u", "[first + k] -= u"
"""An edit of code of another file that it takes in, after which it is -1."""

QUERY = """
import numpy as np
from remosplat_drake.oracle.kernels.nearest_voxel import query
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
print("ready", flush=True)
input()
unseen = np.zeros((4, 4, 4), bool)
unseen[0] = True
field, answer = UnknownSpaceField(unseen, np.zeros(3), 1.0), np.empty((1, 8))
query(field.compiled, np.array([[2.5, 2.0, 2.0, 9.0, -9.0]]), answer)
print(answer[0, 1], sum(query.stats.cache_hits.values()))
"""
"""Prints the distance to unseen space."""

KINDS = "oracle/voxel_octree.py", "UNSEEN = 0, 1", "UNSEEN = 1, 0"
"""An edit of a constant, in a file that nothing is compiled of."""


class Checkout:
    """A copy of the package, whose kernels Python processes use."""

    def __init__(self, folder: Path):
        self.folder = folder
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(PACKAGE, folder / PACKAGE.name, ignore=ignored)

    def edit(self, file: str, old: str, new: str) -> None:
        """Replaces a text by another one, and leaves the file as old."""
        path = self.folder / PACKAGE.name / file
        before, text = path.stat(), path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))

    def started(self, program: str, **environment: str) -> subprocess.Popen:
        """Returns a process that has imported a kernel and waits."""
        process = subprocess.Popen(
            [sys.executable, "-c", program],
            cwd=self.folder,
            env=os.environ | {"PYTHONPATH": str(self.folder)} | environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        return process

    def answers(self, program: str, **environment: str) -> list[float]:
        """Returns the numbers that a process of its own prints."""
        return told(self.started(program, **environment))


def told(process: subprocess.Popen) -> list[float]:
    """Returns the numbers that a process prints, which goes on now."""
    output, _ = process.communicate("\n")
    assert process.returncode == 0
    return [float(word) for word in output.split()]


@pytest.fixture
def checkout(tmp_path) -> Checkout:
    return Checkout(tmp_path / "checkout")


def test_fresh_kernels_stay(checkout):
    assert checkout.answers(CHAIN) == [1.0, 0]
    assert checkout.answers(CHAIN) == [1.0, 1]
    checkout.edit("commands/main.py", "USER_ERROR = 2", "USER_ERROR = 3")
    assert checkout.answers(CHAIN) == [1.0, 1]


@pytest.mark.parametrize(
    ("program", "edit", "variable"),
    [
        (CHAIN, FORWARDS, "UNUSED"),
        (CHAIN, FORWARDS, "NUMBA_CACHE_DIR"),
        (QUERY, KINDS, "UNUSED"),
    ],
)
def test_other_sources_are_noticed(checkout, tmp_path, program, edit, variable):
    """Wherever kernels are kept, and no command has to be run."""
    environment = {variable: str(tmp_path / "kernels")}
    before, _ = checkout.answers(program, **environment)
    checkout.edit(*edit)
    after, hits = checkout.answers(program, **environment)
    assert after != before
    assert hits == 0
    checkout.edit(edit[0], edit[2], edit[1])
    again, _ = checkout.answers(program, **environment)
    assert again == before


def test_what_is_left_of_other_sources_is_deleted(checkout):
    """Of a function that is on another line now, say, or gone."""
    left = checkout.folder / PACKAGE.name / "base" / "__pycache__"
    left /= "gone.function-1.py311.nbi"
    program = "import remosplat_drake.base.kernels; print('ready', flush=True)"
    checkout.answers(program)
    left.touch()
    checkout.answers(program)
    assert left.exists()
    checkout.edit(*FORWARDS)
    checkout.answers(program)
    assert not left.exists()


def test_old_sources_that_are_still_running_compile_for_nobody(checkout):
    """Else the next process would find the code of what was edited."""
    old = checkout.started(CHAIN)
    checkout.edit(*FORWARDS)
    assert told(old) == [1.0, 0]
    assert checkout.answers(CHAIN) == [-1.0, 0]


def test_each_process_finds_the_kernels_of_its_own_sources(checkout):
    old = checkout.started(CHAIN)
    checkout.edit(*FORWARDS)
    assert checkout.answers(CHAIN) == [-1.0, 0]
    assert told(old) == [1.0, 0]
    assert checkout.answers(CHAIN) == [-1.0, 1]


MINE = """
import numpy as np
from numba import njit
from remosplat_drake.robot.kinematics import advance

@njit(cache=True)
def mine(q):
    return advance(q, np.ones(1), 0, 1.0)[0]

print("ready", flush=True)
input()
print(mine(np.zeros(1)), sum(mine.stats.cache_hits.values()))
"""


def test_kernels_elsewhere_take_in_the_package_too(checkout, tmp_path):
    (tmp_path / "checkout" / "mine.py").write_text(MINE)
    assert checkout.answers("import mine") == [1.0, 0]
    assert checkout.answers("import mine") == [1.0, 1]
    checkout.edit(*FORWARDS)
    assert checkout.answers("import mine") == [-1.0, 0]


def test_what_files_with_kernels_import_counts():
    """The files are found by their text; here, by their syntax."""
    paths = map(str, PACKAGE.rglob("*.py"))
    names = {x.decode() for x in list(kernel_sources._sources(paths))[::2]}
    assert "controller.ingredients.collision_damper" in names
    for name in names:
        path = PACKAGE / Path(*name.split(".")).with_suffix(".py")
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.Import):
                assert all(
                    PACKAGE.name not in alias.name for alias in node.names
                )
            if not isinstance(node, ast.ImportFrom):
                continue
            package, _, module = str(node.module).partition(".")
            if package == PACKAGE.name:
                used = {f"{module}.{alias.name}" for alias in node.names}
                assert names & {module, f"{module}.__init__", *used}, module
