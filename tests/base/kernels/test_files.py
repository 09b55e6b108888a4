"""Files of kernels, which many processes write."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from effort import effort

from remosplat_drake.base.kernels import files

KERNELS = """
from remosplat_drake.base.kernels import kernel
@kernel
def successor(x):
    return x + 1
"""

CALLED = """
import kernels_of_mine
answer = kernels_of_mine.successor(1)
(variant,) = kernels_of_mine.successor.variants
print(answer, variant.was_kept)
"""


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """A folder with a kernel's source, and none that are compiled."""
    (tmp_path / "kernels_of_mine.py").write_text(KERNELS)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kernels"))
    return tmp_path


def called(folder: Path, program: str = CALLED) -> str:
    answer = subprocess.run(
        [sys.executable, "-c", program],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert answer.returncode == 0, answer.stderr
    return answer.stdout


def test_they_are_where_the_user_says_or_in_the_cache(monkeypatch, tmp_path):
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert files.kernels_dir() == tmp_path / "remosplat_drake" / "kernels"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "mine"))
    assert files.kernels_dir() == tmp_path / "mine"


def test_those_of_a_wheel_are_found(folder, monkeypatch):
    monkeypatch.setattr(files, "PACKAGED", folder)
    assert files.find("a.kernel") is None
    (folder / "a.kernel").touch()
    assert files.find("a.kernel") == folder / "a.kernel"
    files.write("a.kernel", ("newer",))
    found = files.find("a.kernel")
    assert found == folder / "kernels" / "a.kernel"
    assert files.read(found) == ("newer",)


def test_a_damaged_file_is_written_anew(folder):
    assert called(folder) == "2 False\n"
    assert called(folder) == "2 True\n"
    (path,) = (folder / "kernels").glob("successor-*.kernel")
    whole = path.read_bytes()
    half = whole[: len(whole) // 2]
    for damaged in effort((half,), (b"", half, b"words")):
        path.write_bytes(damaged)
        assert called(folder) == "2 False\n"
        assert called(folder) == "2 True\n"


FULL_DISK = """
import resource
import kernels_of_mine
_, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
print(kernels_of_mine.successor(1))
"""


def test_a_kernel_that_cannot_be_kept_works(folder):
    """A first start on a full disk compiles for itself."""
    assert called(folder, FULL_DISK) == "2\n"
    assert not list(folder.rglob("*.kernel"))


def test_nothing_is_kept_where_no_folder_can_be_made(folder):
    (folder / "kernels").write_text("a file")
    assert called(folder) == "2 False\n"


def test_the_oldest_go_when_there_are_too_many(folder, monkeypatch):
    monkeypatch.setattr(files, "_MOST", 2500)
    for k in range(4):
        files.write(f"{k}.kernel", (b"x" * 1000,))
        os.utime(files.kernels_dir() / f"{k}.kernel", (k, k))
    files.write("4.kernel", ())
    left = {path.name for path in files.kernels_dir().glob("*.kernel")}
    assert left == {"3.kernel", "4.kernel"} | (left & {"2.kernel"})


TOGETHER = """
import sys
import kernels_of_mine
print("ready", flush=True)
input()
""" + CALLED.replace("import kernels_of_mine\n", "")


def test_one_process_compiles_what_several_need(folder):
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", TOGETHER],
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(effort(2, 4))
    ]
    for process in processes:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
    for process in processes:
        assert process.stdin is not None
        process.stdin.write("\n")
        process.stdin.flush()
    answers = sorted(process.communicate()[0] for process in processes)
    assert answers == ["2 False\n"] + (len(processes) - 1) * ["2 True\n"]
