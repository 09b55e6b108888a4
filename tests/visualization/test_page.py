"""Tests of the Meshcat page itself."""

import os

import pytest
from pydrake.geometry import Box
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.visualization import page as page_module
from remosplat_drake.visualization import page_state
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_state import (
    RELEASE,
    START,
    STOP,
    STOPPED,
    PageState,
    ended,
    waiting,
)
from remosplat_drake.visualization.page_style import (
    BUTTONS,
    button,
    heading,
    slider,
)
from remosplat_drake.visualization.scene_look import LIVE


def test_taken_port_is_named():
    first = MeshcatPage(port=17_431)
    with pytest.raises(RemoSplatError, match="port 17431 is taken"):
        MeshcatPage(port=17_431)
    assert first.url.endswith(":17431")


def test_a_port_taken_after_its_check_is_left_out(monkeypatch):
    monkeypatch.setattr(page_module, "is_free", lambda host, port: True)
    first, second = MeshcatPage(), MeshcatPage()
    assert first.url != second.url


# Drake aborts the process at 1 and wraps 80000 around.
@pytest.mark.parametrize("port", [0, 1, 80_000])
def test_port_out_of_range_is_rejected(port):
    with pytest.raises(RemoSplatError, match=f"port {port} is out of range"):
        MeshcatPage(port=port)


def test_page_is_dressed(page, is_visible):
    assert page.meshcat.HasPath("/remosplat/floor")
    assert not is_visible(page.meshcat, "/Grid")
    assert not is_visible(page.meshcat, "/Axes")
    assert not MeshcatPage(floor=False).meshcat.HasPath("/remosplat/floor")


def test_status_replaces_the_previous_one(page):
    page.set_status("optimal")
    page.set_status("relaxed")
    assert page.status == {"controller": "relaxed"}
    page.set_status("")
    assert page.status == {"controller": ""}
    # Meshcat's panel would be laid out anew with each line of text.
    assert page.meshcat.GetButtonNames() == []


def test_text_is_shown_as_it_is():
    """No quotation mark ends Meshcat's script, no bracket begins a tag."""
    text = button("<b> 'C:\\n' is \"odd\" &\n more")
    shown = "&lt;b&gt; &#x27;C:&#92;n&#x27; is &quot;odd&quot; &amp; more"
    assert shown in text
    for name in (heading("a"), button("a", "b"), slider("a", "b")):
        assert "'" not in name and "\\" not in name


def test_save_html_replaces_the_file_whole(page, tmp_path):
    path = tmp_path / "run.html"
    path.write_text("old")
    page.save_html(path)
    assert path.read_text().lstrip().lower().startswith("<!doctype html>")
    assert os.listdir(tmp_path) == ["run.html"]


def test_save_html_names_a_file_that_cannot_be_written(page, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match=r"file/run\.html: "):
        page.save_html(tmp_path / "file" / "run.html")


def test_recording_is_part_of_the_saved_page(page, tmp_path, is_visible):
    page.meshcat.SetObject("/remosplat/thing", Box(1, 1, 1))
    page.save_html(tmp_path / "still.html")
    page.start_recording()
    for k in range(10):
        page.meshcat.SetTransform(
            "/remosplat/thing",
            RigidTransform([0.1 * k, 0, 0]),
            time_in_recording=k / 32,
        )
    page.finish_recording()
    page.save_html(tmp_path / "moving.html")
    still = (tmp_path / "still.html").stat().st_size
    # Ten keys of a position and a quaternion, at least four bytes a number.
    assert (tmp_path / "moving.html").stat().st_size > still + 10 * 7 * 4
    assert is_visible(page.meshcat, LIVE)


def test_buttons_are_there_as_long_as_they_do_something(page, click):
    names = page.meshcat.GetButtonNames

    def offered():
        return {b for b, name in BUTTONS.items() if name in names()}

    page.show(waiting("A run"))
    assert offered() == {START}
    click(page.meshcat, BUTTONS[START])
    live = PageState(page_state.LIVE, "Live", "", (STOP,))
    page.show(live)
    assert offered() == {STOP}
    click(page.meshcat, BUTTONS[STOP])
    page.show(PageState(STOPPED, "Stopped", "stop button", (STOP, RELEASE)))
    assert offered() == {STOP, RELEASE}
    click(page.meshcat, BUTTONS[RELEASE])
    page.show(live)
    assert offered() == {STOP}
    # Pressed buttons stay pressed, for any sequence of visitors.
    assert [page.clicks(b) for b in (START, STOP, RELEASE)] == [1, 1, 1]
    page.set_status("move, age of measurement: 0 ms", "robot")
    page.end(ended("in 3.2 s", reached=True))
    assert offered() == set() and page.status["robot"] == ""
    assert [page.clicks(b) for b in (START, STOP, RELEASE)] == [1, 1, 1]
    click(page.meshcat, BUTTONS[STOP])
    assert page.clicks(STOP) == 1
