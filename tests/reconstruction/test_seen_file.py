"""Seen space as a file: it comes back as it was, or is refused by name."""

from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.base.errors import FileError
from remosplat_drake.reconstruction.seen_file import (
    read_seen_space,
    seen_path,
    write_seen_space,
)
from remosplat_drake.signals.coverage import Coverage


@pytest.fixture
def coverage() -> Coverage:
    rng = np.random.default_rng(0)
    state = rng.integers(0, 3, (7, 5, 3)).astype(np.uint8)
    return Coverage(np.array([-1.0, 0.5, 0.01]), 0.04, state)


@pytest.fixture
def splat(tmp_path, coverage) -> Path:
    path = tmp_path / "a.ply"
    path.write_bytes(b"the splat itself is not read")
    write_seen_space(path, coverage)
    return path


def test_it_comes_back_as_it_was(splat, coverage):
    assert seen_path(splat).name == "a.seen"
    read = read_seen_space(seen_path(splat), splat)
    np.testing.assert_array_equal(read.state, coverage.state)
    np.testing.assert_array_equal(read.lower, coverage.lower)
    assert read.voxel == coverage.voxel


def test_of_another_splat_it_is_refused(splat):
    splat.write_bytes(b"another splat")
    with pytest.raises(FileError, match=r"a\.seen.*another splat than a\.ply"):
        read_seen_space(seen_path(splat), splat)


def test_damage_is_told(splat, coverage):
    path = seen_path(splat)
    whole = path.read_bytes()
    told = 0
    for at in range(0, len(whole), 3):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 4]) + whole[at + 1 :])
        try:
            read = read_seen_space(path, splat)
        except FileError:
            told += 1
        else:
            # It was a byte that only fills up.
            np.testing.assert_array_equal(read.state, coverage.state)
    assert told > 100
    path.write_bytes(whole[:-1])
    with pytest.raises(FileError, match="is truncated"):
        read_seen_space(path, splat)
