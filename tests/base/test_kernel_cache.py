"""Variants of one function that many processes save."""

import subprocess
import sys

from remosplat_drake.base.kernel_cache import KernelCacheFile

SAVE = """
import sys
from numba.core import caching
import remosplat_drake.base.kernels

folder, name = sys.argv[1:]
file = caching.IndexDataCacheFile(folder, "mine", "stamp")
print("ready", flush=True)
input()
for i in range(40):
    file.save((name, i), f"variant {i} of {name}")
    assert file.load((name, i)) == f"variant {i} of {name}"
"""


def test_nothing_that_many_processes_save_is_lost_or_mixed_up(tmp_path):
    names = "abcd"
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", SAVE, str(tmp_path), name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for name in names
    ]
    for process in processes:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
    for process in processes:
        assert process.stdin is not None
        process.stdin.write("\n")
        process.stdin.flush()
    assert [process.wait() for process in processes] == [0] * len(names)
    file = KernelCacheFile(str(tmp_path), "mine", "stamp")
    for name in names:
        for i in range(40):
            assert file.load((name, i)) == f"variant {i} of {name}"


def test_a_folder_that_is_not_there_holds_nothing(tmp_path):
    file = KernelCacheFile(str(tmp_path / "none"), "mine", "stamp")
    assert file.load("a") is None


def test_processes_without_the_package_find_what_they_have_saved(tmp_path):
    arguments = str(tmp_path), "mine", "stamp"
    (numbas,) = KernelCacheFile.__bases__
    theirs, ours = numbas(*arguments), KernelCacheFile(*arguments)
    theirs.save("a", "of another process")
    assert ours.load("a") is None
    ours.save("a", "of this one")
    assert theirs.load("a") == "of another process"
    assert ours.load("a") == "of this one"


FULL_DISK = """
import resource
import kernels_of_mine
_, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
print(kernels_of_mine.successor(1))
"""

KERNELS = """
from remosplat_drake.base.kernels import kernel
@kernel
def successor(x):
    return x + 1
"""


def test_a_kernel_that_cannot_be_kept_works(tmp_path):
    """A first start on a full disk compiles for itself."""
    (tmp_path / "kernels_of_mine.py").write_text(KERNELS)
    answer = subprocess.run(
        [sys.executable, "-c", FULL_DISK],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout == "2\n"
    assert not list(tmp_path.rglob("*.nb*"))
