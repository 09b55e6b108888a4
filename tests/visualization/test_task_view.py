"""A task on the page: its steps, and objects that can be clicked."""

import pytest
from browser import find_chromium, open_browser
from pydrake.common.value import Value
from pydrake.math import RigidTransform

from remosplat_drake.scene.objects.drake_shapes import drake_shape
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Cylinder
from remosplat_drake.signals.task_outline import (
    AHEAD,
    DONE,
    PRESENT,
    OutlineLine,
    OutlineObject,
    TaskOutline,
)
from remosplat_drake.visualization.object_view import OBJECTS, ObjectView
from remosplat_drake.visualization.task_view import TaskView

CAN = SceneObject("can", Cylinder(RigidTransform([0.0, 0.0, 0.3]), 0.1, 0.2))
OUTLINE = TaskOutline(
    (
        OutlineLine("pick the can", PRESENT),
        OutlineLine("reaches for the can", DONE, True),
        OutlineLine("approaches the can", PRESENT, True),
        OutlineLine("place the can", AHEAD),
    ),
    (
        OutlineObject("can", "the hand may touch it", True),
        OutlineObject("tray", "nothing may touch it"),
    ),
    ("grasps the can: the hand has closed on nothing",),
)


def show(page, told):
    view = TaskView(page=page)
    context = view.CreateDefaultContext()
    view.GetInputPort("outline").FixValue(context, Value(told))
    view.ForcedPublish(context)


def test_the_page_is_told_once(page):
    show(page, OUTLINE)
    told = page.told("task")
    assert told["root"] == OBJECTS
    assert [line["state"] for line in told["lines"]] == [
        PRESENT,
        DONE,
        PRESENT,
        AHEAD,
    ]
    assert told["objects"][0]["may_be_touched"]
    view = TaskView(page=page)
    context = view.CreateDefaultContext()
    view.GetInputPort("outline").FixValue(context, Value(TaskOutline()))
    view.ForcedPublish(context)
    assert page.told("task") is told


@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
@pytest.mark.slow
def test_objects_are_chosen_in_the_list_and_in_the_scene(page):
    show(page, OUTLINE)
    path = f"{OBJECTS}/can"
    page.meshcat.SetObject(path, drake_shape(CAN.solid), ObjectView.COLOR)
    page.meshcat.SetTransform(path, CAN.X_WO)
    page.look_from([-1.5, 0.0, 0.3], [0.0, 0.0, 0.3])
    with open_browser() as tab:
        tab.listen_to_console()
        tab.open(page.url)
        now = "document.querySelector('#task [aria-current]').innerText"
        tab.wait_for(f"{now} == 'pick the can'")
        assert tab.evaluate(
            "[...document.querySelectorAll('#task li')].map(e =>"
            " e.dataset.state).join()"
        ) == ",".join(line.state for line in OUTLINE.lines)
        chosen = "document.querySelector('#task [aria-pressed=true]')"
        assert tab.evaluate(chosen) is None
        colour = (
            f"viewer.scene_tree.find({path.split('/')[1:]!r})"
            ".object.children[0].material.color.r"
        )
        tab.wait_for(f"{colour} > 0")
        plain = tab.evaluate(colour)
        tab.click("#task button", text="can")
        tab.wait_for(f"{chosen}?.dataset.object == 'can'")
        assert tab.evaluate(colour) > plain
        tab.click("#task button", text="can")
        tab.wait_for(f"!{chosen}")
        assert tab.evaluate(colour) == pytest.approx(plain, abs=0.002)
        # It is in the middle of the picture.
        tab.click("canvas")
        tab.wait_for(f"{chosen}?.dataset.object == 'can'")
        assert tab.evaluate(colour) > plain
        assert tab.console() == []
