"""Tests of the view of predicted paths."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.common.value import Value

from remosplat_drake.controller.guidance.rollout import Rollout
from remosplat_drake.controller.guidance.selection import Selection
from remosplat_drake.controller.program.guidance import make_candidates
from remosplat_drake.visualization.guidance_view import (
    FUTURES,
    GuidanceView,
    spaced_points,
)

DIRECT, LEFT, RIGHT = make_candidates([0.021])[0]


def future(guidance, y: float, n: int = 20) -> Rollout:
    path = tuple(np.array([0.02 * k, y, 0.5]) for k in range(n))
    return Rollout(guidance, np.zeros(1), np.zeros(1), path=path)


@pytest.fixture
def show(page):
    """A function that shows a selection to one and the same view."""
    dut = GuidanceView(page=page)
    context = dut.CreateDefaultContext()
    port = dut.GetInputPort("selection")

    def _show(selection: Selection):
        port.FixValue(context, Value(selection))
        context.SetTime(context.get_time() + 1.0)
        dut.ForcedPublish(context)

    return _show


@pytest.fixture
def selection() -> Selection:
    latest = (future(DIRECT, 0.0), future(LEFT, 0.1), future(RIGHT, -0.1))
    return Selection(LEFT, "direct stalled, left reached", latest=latest)


def alpha(page, path: str) -> bytes:
    """The packed opacity of what is drawn at a path."""
    packed = page.meshcat._GetPackedObject(path)
    start = packed.index(b"opacity") + len(b"opacity")
    return packed[start : start + 9]


def test_every_future_is_drawn_and_the_chosen_one_is_solid(
    show, page, selection
):
    show(selection)
    paths = [f"{FUTURES}/{name}" for name in ("0_direct", "1_left", "2_right")]
    assert all(page.meshcat.HasPath(path) for path in paths)
    faint, solid, other = (alpha(page, path) for path in paths)
    assert faint == other != solid


def test_the_page_says_what_was_chosen(show, page, selection):
    show(Selection(DIRECT))
    assert page.status["guidance"] == "direct"
    show(selection)
    assert page.status["guidance"] == "left"


def test_it_is_told_why_nothing_is_rolled_out(show, page):
    show(Selection(LEFT, missing="the process has died"))
    assert page.status["guidance"] == "left the process has died"
    assert not page.meshcat.HasPath(FUTURES)


def test_an_old_round_is_wiped_off(show, page, selection):
    show(selection)
    show(dc.replace(selection, latest=(future(LEFT, 0.1),)))
    assert page.meshcat.HasPath(f"{FUTURES}/0_left")
    assert not page.meshcat.HasPath(f"{FUTURES}/2_right")
    show(Selection(LEFT, "new target"))
    assert not page.meshcat.HasPath(FUTURES)


def test_a_round_is_sent_once(show, page, selection):
    show(selection)
    sent = page.meshcat._GetPackedObject(f"{FUTURES}/1_left")
    show(dc.replace(selection, seconds=1.0))
    # Every object that is sent gets identifiers of its own.
    assert page.meshcat._GetPackedObject(f"{FUTURES}/1_left") == sent


def test_a_future_that_stands_still_is_not_drawn(show, page):
    here = tuple(np.array([0.5, 0.0, 0.5]) for _ in range(9))
    still = dc.replace(future(DIRECT, 0.0), path=here)
    show(Selection(DIRECT, latest=(still, future(LEFT, 0.1))))
    assert not page.meshcat.HasPath(f"{FUTURES}/0_direct")
    assert page.meshcat.HasPath(f"{FUTURES}/1_left")


def test_points_are_kept_a_step_apart():
    p = np.array([[0.0, 0, 0], [0.3, 0, 0], [1.0, 0, 0], [2.0, 0, 0]])
    np.testing.assert_array_equal(spaced_points(p, 0.9), p[[0, 2, 3]])
    assert not len(spaced_points(np.zeros((0, 3)), 0.9))
