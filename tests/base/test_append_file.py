"""A file that only grows, on a disk that is full."""

import subprocess
import sys

import pytest

from remosplat_drake.base.append_file import AppendFile
from remosplat_drake.base.errors import FileError


def test_pieces_follow_one_another(tmp_path):
    path = tmp_path / "deep" / "file"
    file = AppendFile(path, b"start ")
    assert file.append(b"one ") == ""
    assert path.read_bytes() == b"start one "
    assert file.append(memoryview(b"two")) == ""
    file.close()
    assert path.read_bytes() == b"start one two"


def test_what_exists_is_not_written_over(tmp_path):
    path = tmp_path / "file"
    path.write_text("of another run")
    with pytest.raises(FileError, match="exists"):
        AppendFile(path)
    assert path.read_text() == "of another run"


# A process that may not write files of more than 100 bytes: to it, that is
# what a full disk is. Half of the third piece would fit.
_LIMITED = """
import resource, sys
from pathlib import Path
from remosplat_drake.base.append_file import AppendFile
resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
file = AppendFile(Path(sys.argv[1]))
for _ in range(3):
    print(file.append(bytes(40)) or "appended")
print(file.append(b"short") or "appended")
"""


def test_a_piece_that_does_not_fit_is_left_out_as_a_whole(tmp_path):
    path = tmp_path / "file"
    answer = subprocess.run(
        [sys.executable, "-c", _LIMITED, path],
        capture_output=True,
        text=True,
        check=True,
    )
    assert answer.stdout.splitlines() == [
        "appended",
        "appended",
        "File too large",
        "appended",
    ]
    assert path.read_bytes() == bytes(80) + b"short"


@pytest.mark.parametrize(
    ("is_there", "problem"),
    [(False, "was moved or deleted"), (True, "was replaced")],
)
def test_a_file_that_is_taken_away_is_named(tmp_path, is_there, problem):
    """As where logs are rotated."""
    path = tmp_path / "file"
    file = AppendFile(path)
    path.rename(tmp_path / "file.1")
    if is_there:
        path.write_text("another")
    assert file.append(b"rows") == ""
    assert problem in file.close()
    assert AppendFile(tmp_path / "whole").close() == ""
