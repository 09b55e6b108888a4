"""The folders of a session's runs."""

import pytest

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.mapping.store.run_folders import (
    find_run,
    new_run,
    run_numbers,
)


def test_runs_are_counted(tmp_path):
    assert new_run(tmp_path).name == "0001"
    assert new_run(tmp_path).name == "0002"
    (tmp_path / "runs" / "notes").mkdir()
    (tmp_path / "runs" / "0007").mkdir()
    assert new_run(tmp_path).name == "0008"
    assert run_numbers(tmp_path) == [1, 2, 7, 8]


def test_a_run_is_found_by_its_number(tmp_path):
    first, last = new_run(tmp_path), new_run(tmp_path)
    assert find_run(tmp_path, 1) == first
    assert find_run(tmp_path) == last


def test_a_run_that_is_not_there_is_an_error_of_the_user(tmp_path):
    with pytest.raises(FileError, match="no recorded runs"):
        find_run(tmp_path)
    new_run(tmp_path)
    with pytest.raises(FieldError, match="run: no 3; valid: 1"):
        find_run(tmp_path, 3)


def test_a_session_that_cannot_be_written(tmp_path):
    (tmp_path / "runs").write_text("a file")
    with pytest.raises(FileError, match="0001"):
        new_run(tmp_path)
