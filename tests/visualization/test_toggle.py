"""Tests of buttons that step through states."""

from pydrake.geometry import Sphere

from remosplat_drake.visualization.toggle import Toggle


def test_clicks_step_through_the_states(page, click, is_visible):
    meshcat = page.meshcat
    for path in ("/a", "/b"):
        meshcat.SetObject(path, Sphere(1))
    dut = Toggle(
        meshcat, label="Show", keycode="Digit9", states=[["/a"], ["/b"], []]
    )
    page.add_toggle(dut)

    def shown():
        page.poll()
        return [is_visible(meshcat, path) for path in ("/a", "/b")]

    assert shown() == [True, False]
    click(meshcat, dut.name)
    assert is_visible(meshcat, "/a")  # Nothing happens before a poll.
    assert shown() == [False, True]
    click(meshcat, dut.name)
    assert shown() == [False, False]
    click(meshcat, dut.name)
    click(meshcat, dut.name)
    assert shown() == [False, True]
    assert dut.state == 1


def test_first_state_may_be_any(page, is_visible):
    Toggle(
        page.meshcat,
        label="Show",
        keycode="Digit9",
        states=[["/a"], []],
        initial=1,
    )
    assert not is_visible(page.meshcat, "/a")
