"""Stages of a job that are kept when it is interrupted."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.kept_stages import KeptStages


@dc.dataclass(frozen=True)
class Sum:
    total: np.ndarray


@pytest.fixture
def interrupted(tmp_path):
    """A job whose first stage is finished: 1 + 2."""
    with pytest.raises(KeyboardInterrupt), KeptStages(tmp_path / "job") as s:
        s.kept("a sum", Sum, [1, 2], lambda: Sum(np.array([3.0])))
        raise KeyboardInterrupt
    return tmp_path / "job"


def total(folder, inputs) -> tuple[float, list[str]]:
    """What the first stage gives now, 0 if it is made, and what is told."""
    told = []
    with KeptStages(folder, told.append) as stages:
        made = stages.kept("a sum", Sum, inputs, lambda: Sum(np.zeros(1)))
    return float(made.total[0]), told


def test_a_finished_stage_is_not_done_again(interrupted):
    assert total(interrupted, [1, 2]) == (
        3,
        ["a sum: reuses the kept result"],
    )
    assert not interrupted.exists()


def test_a_stage_of_other_inputs_is_done_again(interrupted):
    again, (line,) = total(interrupted, [1, 3])
    assert again == 0
    assert line.startswith("a sum: computed again: ")
    assert "was made from other input or with other flags" in line


@pytest.mark.parametrize("keep", [0, 10, 100, -1])
def test_a_damaged_stage_is_done_again(interrupted, keep):
    (path,) = interrupted.iterdir()
    path.write_bytes(path.read_bytes()[:keep])
    again, (line,) = total(interrupted, [1, 2])
    assert again == 0 and line.startswith("a sum: computed again: ")
    assert str(path) in line


def test_a_flipped_bit_is_found(interrupted):
    (path,) = interrupted.iterdir()
    data = bytearray(path.read_bytes())
    data[-60] ^= 1
    path.write_bytes(data)
    again, (line,) = total(interrupted, [1, 2])
    assert again == 0 and "checksum" in line


def test_nothing_is_left_of_an_error(tmp_path):
    with pytest.raises(RemoSplatError), KeptStages(tmp_path / "job") as stages:
        stages.kept("a sum", Sum, 1, lambda: Sum(np.ones(1)))
        raise RemoSplatError("a flag is wrong")
    assert not list(tmp_path.iterdir())


def test_made_and_kept_have_the_same_layout(tmp_path):
    """Sums over arrays of another layout might differ in the last bit."""
    columns = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    with pytest.raises(KeyboardInterrupt), KeptStages(tmp_path / "job") as s:
        made = s.kept("a sum", Sum, 1, lambda: Sum(columns))
        assert made.total.flags.c_contiguous
        raise KeyboardInterrupt
    with KeptStages(tmp_path / "job") as stages:
        again = stages.kept("a sum", Sum, 1, lambda: Sum(columns))
    assert again.total.strides == made.total.strides
    np.testing.assert_array_equal(again.total, made.total)
