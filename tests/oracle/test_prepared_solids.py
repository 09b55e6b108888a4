"""Solids in their hierarchy: the same from the cache, on any threads."""

import numpy as np
import pytest
from own_cache import use_cache

from remosplat_drake.base import threads
from remosplat_drake.oracle import prepared_solids
from remosplat_drake.oracle.kernels.solid_records import open_solids
from remosplat_drake.oracle.prepared_solids import (
    prepare_solids,
    splat_records,
)
from remosplat_drake.splat import hierarchy_cache
from remosplat_drake.splat.bvh import hierarchy_of
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.hierarchy_cache import cache_folder


@pytest.fixture(autouse=True)
def _cache(monkeypatch, tmp_path):
    use_cache(monkeypatch, tmp_path)
    monkeypatch.setattr(hierarchy_cache, "LEAST_BOXES", 10)


@pytest.fixture
def builds(monkeypatch):
    """Counts how often a hierarchy is built."""
    built = []

    def counted(table):
        built.append(len(table))
        return hierarchy_of(table)

    monkeypatch.setattr(prepared_solids, "hierarchy_of", counted)
    return built


def _splat(seed: int = 0, n: int = 500, scales: int = 2) -> GaussianSplat:
    rng = np.random.default_rng(seed)
    return GaussianSplat(
        rng.normal(size=(n, 3)),
        rng.normal(size=(n, 4)),
        rng.uniform(0.01, 0.2, (n, scales)),
        rng.uniform(0.01, 1, n),
        rng.uniform(size=(n, 3)),
        uncertainty=rng.uniform(0, 0.1, n),
    )


def _prepared(splat, n_sigma=1.0, min_opacity=0.1, solved=True):
    return prepare_solids(splat, n_sigma, min_opacity, solved)


def _assert_same(one: dict, other: dict) -> None:
    for name, array in one.items():
        # As bytes: links that are stored among the nodes may look like NaN.
        assert array.dtype == other[name].dtype
        assert array.tobytes() == other[name].tobytes()


def test_records_stand_in_leaf_order():
    splat = _splat()
    prepared = _prepared(splat)
    records, index = splat_records(splat, 0.1, 1.0)
    place = np.searchsorted(index, prepared["order"])
    np.testing.assert_array_equal(index[place], prepared["order"])
    opened = np.empty((len(place), 16))
    open_solids(prepared["records"], 1.0, opened)
    np.testing.assert_array_equal(opened, records[place])


def test_a_hierarchy_is_built_once(builds):
    splat = _splat()
    first = _prepared(splat)
    _assert_same(_prepared(_splat()), first)
    assert len(builds) == 1


def test_all_that_the_boxes_follow_from_is_in_the_key(builds):
    splat = _splat()
    other_colors = GaussianSplat.restored(
        splat.arrays() | {"colors": 1 - splat.colors}
    )
    _prepared(splat)
    _prepared(other_colors)
    assert len(builds) == 1
    _prepared(_splat(1))
    _prepared(_splat(0, scales=3))
    _prepared(splat.with_uncertainty(None))
    _prepared(splat.with_uncertainty(0.0))
    _prepared(splat, n_sigma=2.0)
    _prepared(splat, min_opacity=0.2)
    _prepared(splat, solved=False)
    assert len(builds) == 8


def test_few_splats_are_not_kept():
    _prepared(_splat(n=9))
    assert not cache_folder().exists()


@pytest.mark.parametrize("solved", [True, False])
@pytest.mark.parametrize("column", [*range(14)])
def test_a_hierarchy_whose_boxes_are_too_small_is_made_again(
    builds, monkeypatch, solved, column
):
    """A cache may be sound, and yet be of a program of other boxes."""
    splat = _splat()
    first = _prepared(splat, solved=solved)

    def shrunk(key, n):
        hierarchy = hierarchy_cache.kept_hierarchy(key, n)
        nodes = hierarchy.nodes.copy()
        # Each box has something at its border.
        sign = 1 if column < 12 and column % 6 < 3 else -1
        nodes[-1, column] += sign * 1e-3 * (1 + abs(nodes[-1, column]))
        return hierarchy.of(nodes, hierarchy.order)

    monkeypatch.setattr(prepared_solids, "kept_hierarchy", shrunk)
    _assert_same(_prepared(splat, solved=solved), first)
    assert len(builds) == 2


def test_a_hierarchy_of_another_order_is_made_again(builds, monkeypatch):
    splat = _splat()
    first = _prepared(splat)

    def turned(key, n):
        hierarchy = hierarchy_cache.kept_hierarchy(key, n)
        return hierarchy.of(hierarchy.nodes, hierarchy.order[::-1].copy())

    monkeypatch.setattr(prepared_solids, "kept_hierarchy", turned)
    _assert_same(_prepared(splat), first)
    assert len(builds) == 2


def test_threads_change_nothing(monkeypatch):
    splat = _splat(n=3000)
    expected = _prepared(splat)
    monkeypatch.setattr(prepared_solids, "_SHARE", 300)
    monkeypatch.setattr(prepared_solids, "_BLOCK", 64)
    monkeypatch.setattr(hierarchy_cache, "LEAST_BOXES", 10_000)
    for count in (1, 3):
        monkeypatch.setattr(threads, "num_threads", lambda n=count: n)
        _assert_same(_prepared(splat), expected)
