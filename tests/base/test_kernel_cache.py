"""Compiled kernels do not outlive the sources they were made from."""

import os

import pytest

from remosplat_drake.base.kernel_cache import drop_stale_kernels


@pytest.fixture
def package(tmp_path):
    """Two modules with one compiled kernel each, compiled a second later."""
    cache = tmp_path / "stage" / "__pycache__"
    cache.mkdir(parents=True)
    for name in ("outer", "inner"):
        source = tmp_path / "stage" / f"{name}.py"
        source.write_text("from numba import njit")
        os.utime(source, (100, 100))
        for ending in ("nbi", "1.nbc"):
            compiled = cache / f"{name}.kernel-12.py311.{ending}"
            compiled.touch()
            os.utime(compiled, (101, 101))
    return tmp_path


def compiled(package) -> int:
    return len(list(package.rglob("*.nb?")))


def test_fresh_kernels_stay(package):
    assert not drop_stale_kernels(package)
    assert compiled(package) == 4


def test_one_edited_source_drops_all(package):
    os.utime(package / "stage" / "inner.py", (102, 102))
    assert drop_stale_kernels(package)
    assert compiled(package) == 0


def test_code_that_kernels_take_in_matters(package):
    """Its own file has no compiled kernel that could be older."""
    helpers = package / "stage" / "helpers.py"
    helpers.write_text("from remosplat_drake.base.kernels import helper")
    os.utime(helpers, (100, 100))
    assert not drop_stale_kernels(package)
    os.utime(helpers, (102, 102))
    assert drop_stale_kernels(package)


def test_a_source_without_kernels_does_not_matter(package):
    (package / "stage" / "plain.py").touch()
    assert not drop_stale_kernels(package)


def test_nothing_compiled_is_nothing_stale(tmp_path):
    assert not drop_stale_kernels(tmp_path)


def test_kernels_elsewhere_take_in_the_package_too(package, tmp_path_factory):
    tests = tmp_path_factory.mktemp("tests")
    (tests / "__pycache__").mkdir()
    kernel = tests / "__pycache__" / "mine.kernel-1.py311.nbi"
    kernel.touch()
    os.utime(kernel, (103, 103))
    assert not drop_stale_kernels(package, tests)
    os.utime(package / "stage" / "inner.py", (102, 102))
    assert drop_stale_kernels(package, tests)
    assert not kernel.exists()
