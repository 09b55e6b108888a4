"""Packages that are timed where they are, and what is said where not."""

import sys

from remosplat_drake.timing.optional_packages import advice, is_there


def test_nothing_is_advised_where_nothing_is_missing():
    assert advice([]) == ""


def test_what_is_missing_is_named_as_pip_takes_it(monkeypatch):
    for package in ("daqp", "open3d", "proxsuite"):
        monkeypatch.setitem(sys.modules, package, None)
    assert not is_there("daqp")
    line = advice(["proxsuite", "daqp", "open3d"])
    assert line.endswith(
        "pip install proxsuite daqp 'remosplat-drake[reconstruction]'"
    )


def test_a_library_that_the_system_lacks_is_named(monkeypatch, tmp_path):
    text = "raise ImportError('libGL.so.1: cannot open shared object file')"
    (tmp_path / "daqp.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "daqp", raising=False)
    assert not is_there("daqp")
    assert "libgl1" in advice(["daqp"])
