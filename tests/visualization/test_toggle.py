"""Tests of buttons that step through states."""

from pydrake.geometry import Sphere

from remosplat_drake.visualization.toggle import Toggle, on_off


def test_the_first_state_is_shown_to_begin_with(page, is_visible):
    for path in ("/a", "/b"):
        page.meshcat.SetObject(path, Sphere(1))
    states = (("one", ("/a",)), ("other", ("/b",)), ("off", ()))
    page.add_toggle(Toggle("Show", "9", states))
    assert is_visible(page.meshcat, "/a")
    assert not is_visible(page.meshcat, "/b")


def test_what_is_off_to_begin_with_is_hidden(page, is_visible):
    page.add_toggle(on_off("Thing", "8", "/thing", shown=False))
    page.add_toggle(on_off("Other", "7", "/other"))
    assert not is_visible(page.meshcat, "/thing")
    assert is_visible(page.meshcat, "/other")
