"""Files that appear whole or not at all, and knowing early that they can."""

import errno
import os

import pytest

from remosplat_drake.base.atomic_file import (
    atomic_write,
    check_writable,
    replace_checked,
    write_atomically,
)
from remosplat_drake.base.errors import FileError


def test_a_file_is_replaced_as_a_whole(tmp_path):
    file = tmp_path / "new" / "file.txt"
    write_atomically(file, "first")
    with atomic_write(file) as stream:
        stream.write("second")
        assert file.read_text() == "first"
    assert file.read_text() == "second"
    assert os.listdir(file.parent) == ["file.txt"]


@pytest.mark.parametrize(
    ("error", "seen"),
    [
        (ValueError("a defect"), ValueError),
        (KeyboardInterrupt(), KeyboardInterrupt),
        (OSError(errno.ENOSPC, "No space left on device"), FileError),
    ],
)
def test_what_goes_wrong_leaves_the_old_file(tmp_path, error, seen):
    file = tmp_path / "file.txt"
    file.write_text("old")
    with pytest.raises(seen), atomic_write(file) as stream:
        stream.write("half")
        raise error
    assert file.read_text() == "old"
    assert os.listdir(tmp_path) == ["file.txt"]


def test_a_folder_is_no_place_for_a_file(tmp_path):
    with pytest.raises(FileError, match="folder"):
        check_writable(tmp_path)
    with pytest.raises(FileError, match="cannot be written"):
        write_atomically(tmp_path, "text")


def test_nothing_can_be_made_below_a_file(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match="file is not a folder"):
        check_writable(tmp_path / "file" / "a" / "b")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_may_be_closed(tmp_path):
    (tmp_path / "closed").mkdir(mode=0o555)
    with pytest.raises(FileError, match="closed cannot be written"):
        check_writable(tmp_path / "closed" / "a" / "b")


def test_asking_makes_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    check_writable(tmp_path / "a" / "b")
    check_writable(tmp_path.relative_to(tmp_path) / "c")
    assert os.listdir(tmp_path) == []


def test_what_does_not_pass_its_check_is_undone(tmp_path):
    path, seen = tmp_path / "a.yaml", []
    path.write_bytes(b"old\r\n")

    def refuse():
        seen.append(path.read_text())
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        replace_checked(path, "new\n", refuse)
    assert seen == ["new\n"] and path.read_bytes() == b"old\r\n"
    replace_checked(path, "new\n", lambda: None)
    assert path.read_bytes() == b"new\n"
    assert os.listdir(tmp_path) == ["a.yaml"]
