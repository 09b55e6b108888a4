"""Hierarchies in the user's cache: found again, or dropped."""

import os

import numpy as np
import pytest
from own_cache import use_cache

from remosplat_drake.base.array_file import write_arrays
from remosplat_drake.splat import hierarchy_cache
from remosplat_drake.splat.bvh import BoundingVolumeHierarchy, build_hierarchy
from remosplat_drake.splat.hierarchy_cache import (
    cache_folder,
    keep_hierarchy,
    kept_hierarchy,
)


@pytest.fixture(autouse=True)
def _cache(monkeypatch, tmp_path):
    use_cache(monkeypatch, tmp_path)


def _hierarchy(seed: int, n: int = 500) -> BoundingVolumeHierarchy:
    rng = np.random.default_rng(seed)
    lower = rng.normal(size=(n, 3))
    upper = lower + rng.exponential(size=(n, 3))
    return build_hierarchy(lower, upper, lower[:, 2])


def _assert_same(found, expected: BoundingVolumeHierarchy) -> None:
    np.testing.assert_array_equal(found.links, expected.links)
    np.testing.assert_array_equal(found.order, expected.order)
    assert found.order.dtype == expected.order.dtype
    assert not found.nodes.flags.writeable


def test_a_hierarchy_is_found_by_its_key():
    hierarchies = {"a": _hierarchy(0), "b": _hierarchy(1)}
    for key, hierarchy in hierarchies.items():
        assert kept_hierarchy(key, 500) is None
        keep_hierarchy(key, hierarchy)
    for key, hierarchy in hierarchies.items():
        _assert_same(kept_hierarchy(key, 500), hierarchy)


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
def test_what_is_damaged_or_stale_is_dropped(damage):
    keep_hierarchy("a", _hierarchy(0))
    (file,) = cache_folder().iterdir()
    file.write_bytes(damage(file.read_bytes()))
    assert kept_hierarchy("a", 500) is None
    assert not file.exists()


def test_a_hierarchy_of_other_boxes_is_dropped():
    keep_hierarchy("a", _hierarchy(0))
    assert kept_hierarchy("a", 499) is None
    assert not list(cache_folder().iterdir())


def test_a_hierarchy_that_leads_nowhere_is_dropped():
    """A file may be whole, and still hold indices that no kernel may follow."""
    hierarchy = _hierarchy(0)
    nodes = hierarchy.nodes.copy()
    nodes.view(np.int32)[0, 14] = len(nodes)
    keep_hierarchy("a", BoundingVolumeHierarchy.of(nodes, hierarchy.order))
    assert kept_hierarchy("a", 500) is None


def test_tables_of_other_types_are_dropped():
    hierarchy = _hierarchy(0)
    arrays = {"nodes": hierarchy.nodes, "order": hierarchy.order}
    for name, kind in (("nodes", np.float64), ("order", np.float32)):
        wrong = arrays | {name: arrays[name].astype(kind)}
        path = cache_folder() / "a.bvh"
        write_arrays(path, hierarchy_cache._KIND, {}, wrong)
        assert kept_hierarchy("a", 500) is None
        assert not path.exists()


def test_a_full_cache_loses_what_was_not_used_longest(monkeypatch):
    keep_hierarchy("a", _hierarchy(0))
    (first,) = cache_folder().iterdir()
    monkeypatch.setattr(
        hierarchy_cache, "MOST_BYTES", int(2.5 * first.stat().st_size)
    )
    keep_hierarchy("b", _hierarchy(1))
    (second,) = set(cache_folder().iterdir()) - {first}
    # Clocks of file systems are coarse: these are older for certain.
    os.utime(first, (1, 1))
    os.utime(second, (2, 2))
    assert kept_hierarchy("a", 500) is not None  # Used again.
    keep_hierarchy("c", _hierarchy(2))
    left = set(cache_folder().iterdir())
    assert first in left and second not in left and len(left) == 2


def test_a_cache_that_cannot_be_written_stops_no_run(monkeypatch, tmp_path):
    file = tmp_path / "file"
    file.write_text("no folder")
    use_cache(monkeypatch, file)
    keep_hierarchy("a", _hierarchy(0))
    assert kept_hierarchy("a", 500) is None
