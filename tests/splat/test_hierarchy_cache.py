"""Hierarchies in the user's cache: found again, or made again."""

import os

import numpy as np
import pytest

from remosplat_drake.splat import hierarchy_cache
from remosplat_drake.splat.bvh import hierarchy_of
from remosplat_drake.splat.hierarchy_cache import cache_folder, kept_hierarchy


@pytest.fixture(autouse=True)
def _cache(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(hierarchy_cache, "LEAST_BOXES", 10)


def _boxes(seed: int, n: int = 500) -> np.ndarray:
    rng = np.random.default_rng(seed)
    boxes = np.empty((n, 8))
    boxes[:, :3] = rng.normal(size=(n, 3))
    boxes[:, 3:6] = boxes[:, :3] + rng.exponential(size=(n, 3))
    boxes[:, 6] = boxes[:, 2]
    boxes[:, 7] = np.arange(n)
    return boxes


def _assert_same(found, boxes: np.ndarray) -> None:
    expected = hierarchy_of(boxes.copy())
    np.testing.assert_array_equal(found.links, expected.links)
    np.testing.assert_array_equal(found.order, expected.order)
    assert found.order.dtype == expected.order.dtype
    assert not found.nodes.flags.writeable


@pytest.fixture
def builds(monkeypatch):
    """Counts how often a hierarchy is built."""
    built = []

    def counted(boxes):
        built.append(len(boxes))
        return hierarchy_of(boxes)

    monkeypatch.setattr(hierarchy_cache, "hierarchy_of", counted)
    return built


def test_a_hierarchy_is_built_once(builds):
    boxes = _boxes(0)
    for _ in range(3):
        _assert_same(kept_hierarchy(boxes.copy()), boxes)
    assert builds == [500]
    _assert_same(kept_hierarchy(_boxes(1)), _boxes(1))
    assert builds == [500, 500]


def test_few_boxes_are_not_kept(builds):
    kept_hierarchy(_boxes(0, 9))
    assert not cache_folder().exists()


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: data[:1000],
        lambda data: b"",
        lambda data: data[:-400] + b"\1" + data[-399:],
        lambda data: data[:8] + b"\7" + data[9:],
        lambda data: b"x" * len(data),
    ],
    ids=["cut off", "empty", "damaged", "another version", "something else"],
)
def test_what_is_damaged_or_stale_is_made_again(builds, damage):
    boxes = _boxes(0)
    kept_hierarchy(boxes.copy())
    (file,) = cache_folder().iterdir()
    file.write_bytes(damage(file.read_bytes()))
    _assert_same(kept_hierarchy(boxes.copy()), boxes)
    _assert_same(kept_hierarchy(boxes.copy()), boxes)
    assert builds == [500, 500]


def test_a_hierarchy_that_leads_nowhere_is_not_used(builds):
    """A file may be whole, and still hold indices that no kernel may follow."""
    boxes = _boxes(0)
    wrong = hierarchy_of(boxes.copy())
    wrong.nodes.flags.writeable = True
    wrong.nodes.view(np.int32)[0, 14] = len(wrong.nodes)
    kept_hierarchy(boxes.copy())
    (file,) = cache_folder().iterdir()
    hierarchy_cache._write(file, wrong)
    _assert_same(kept_hierarchy(boxes.copy()), boxes)
    assert builds == [500, 500]


def test_a_full_cache_loses_what_was_not_used_longest(monkeypatch, builds):
    kept_hierarchy(_boxes(0))
    (first,) = cache_folder().iterdir()
    monkeypatch.setattr(
        hierarchy_cache, "MOST_BYTES", int(2.5 * first.stat().st_size)
    )
    kept_hierarchy(_boxes(1))
    (second,) = set(cache_folder().iterdir()) - {first}
    # Clocks of file systems are coarse: these are older for certain.
    os.utime(first, (1, 1))
    os.utime(second, (2, 2))
    kept_hierarchy(_boxes(0))  # Used again.
    kept_hierarchy(_boxes(2))
    left = set(cache_folder().iterdir())
    assert first in left and second not in left and len(left) == 2


def test_a_cache_that_cannot_be_written_stops_nobody(monkeypatch, tmp_path):
    file = tmp_path / "file"
    file.write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(file))
    boxes = _boxes(0)
    _assert_same(kept_hierarchy(boxes.copy()), boxes)
