"""The message about the first, slow start."""

import io

import pytest
from rich.console import Console

from remosplat_drake import warm_up


@pytest.fixture
def console() -> Console:
    return Console(file=io.StringIO())


def said(console: Console) -> bool:
    warm_up.announce(console)
    return "compiling" in console.file.getvalue()  # pyright: ignore


def test_it_is_said_until_the_kernels_are_compiled(
    console, tmp_path, monkeypatch
):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert said(console)
    warm_up.remember()
    assert not said(Console(file=io.StringIO()))


def test_a_cache_that_cannot_be_written_stops_nobody(
    console, tmp_path, monkeypatch
):
    (tmp_path / "cache").write_text("a file where the folder should be")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    warm_up.remember()
    assert said(console)
