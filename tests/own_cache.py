"""A cache of a test's own, in which compiled kernels are shared."""

import pytest

from remosplat_drake.base.kernels.files import kernels_dir


def use_cache(monkeypatch: pytest.MonkeyPatch, folder: object) -> None:
    """Moves the user's cache, except for its compiled kernels.

    Without the exception, the test would compile the kernels that it calls.

    Args:
        monkeypatch: The test's fixture.
        folder: The folder of the new cache.
    """
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(kernels_dir()))
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder))
