"""Splats that are made block by block: as if made at once."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from toy_splats import random_splat

from remosplat_drake.base import threads
from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.splat import blocks
from remosplat_drake.splat.blocks import in_blocks
from remosplat_drake.splat.codecs.ply import read_ply, write_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def _make_small(monkeypatch, count: int) -> None:
    monkeypatch.setattr(threads, "num_threads", lambda: count)
    monkeypatch.setattr(blocks, "_BLOCK", 7)


def _assert_same(one: GaussianSplat, other: GaussianSplat) -> None:
    assert one.content_hash == other.content_hash
    for name, array in one.arrays().items():
        np.testing.assert_array_equal(array, other.arrays()[name])
        assert not array.flags.writeable


@pytest.mark.parametrize("n", [1, 7, 8, 50])
@pytest.mark.parametrize("scales", [2, 3])
@pytest.mark.parametrize("threads", [1, 3])
def test_files_and_frames_do_not_show_the_blocks(
    monkeypatch, tmp_path, n, scales, threads
):
    splat = random_splat(scales, 3, n=n).with_uncertainty(np.linspace(0, 1, n))
    write_ply(tmp_path / "s.ply", splat)
    X_FG = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1, 2, 3])
    read = read_ply(tmp_path / "s.ply")
    moved = read.transformed(X_FG, 2.0)
    _make_small(monkeypatch, threads)
    _assert_same(read_ply(tmp_path / "s.ply"), read)
    _assert_same(read.transformed(X_FG, 2.0), moved)


@pytest.mark.parametrize("threads", [1, 3])
def test_errors_count_the_splats_of_all_blocks(monkeypatch, tmp_path, threads):
    _make_small(monkeypatch, threads)
    splat = random_splat(2, 0, n=50)
    wrong = splat.p_GK.copy()
    wrong[[30, 45]] = 3e38
    splat = GaussianSplat.restored(splat.arrays() | {"p_GK": wrong})
    problem = r"p_GK of splat 30 is not finite \(2 such splats\)"
    with pytest.raises(RemoSplatError, match=problem):
        splat.transformed(RigidTransform(), 10.0)
    wrong = wrong.copy()
    wrong[:] = 0
    wrong[40] = np.nan
    splat = GaussianSplat.restored(splat.arrays() | {"p_GK": wrong})
    write_ply(tmp_path / "s.ply", splat)
    with pytest.raises(FileError, match="row 40: x is not finite"):
        read_ply(tmp_path / "s.ply")


def test_no_rows_are_a_block_without_rows():
    arrays = in_blocks(0, lambda rows: {"a": np.zeros((9, 2))[:0][rows]})
    assert arrays["a"].shape == (0, 2)
    assert arrays["a"].dtype == np.float32
