"""Pictures of captures: which axis is up, and odd captures."""

import dataclasses as dc
import io

import numpy as np
import pytest

from remosplat_drake.capture.picture import draw_capture, up_axis

NONE = np.zeros(0, int)


def turned(capture, R_VW):
    """The same capture in another world frame V."""
    X_VW = np.eye(4)
    X_VW[:3, :3] = R_VW
    return dc.replace(capture, X_WC=X_VW @ capture.X_WC)


def test_up_is_found_in_any_world_frame(scene_capture):
    assert up_axis(scene_capture) == (2, 1.0)
    y_down = turned(scene_capture, [[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    assert up_axis(y_down) == (1, -1.0)
    y_up = turned(scene_capture, [[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    assert up_axis(y_up) == (1, 1.0)


@pytest.mark.parametrize("count", [1, pytest.param(7, marks=pytest.mark.slow)])
def test_few_frames_and_no_depth(scene_capture, count):
    few = scene_capture.select(np.arange(count))
    blind = dc.replace(few, depth=np.zeros_like(few.depth))
    for capture in (few, blind):
        file = io.BytesIO()
        draw_capture(capture, "capture", NONE).savefig(file, format="png")
        assert file.tell() > 1000


def test_the_map_is_right_handed(scene_capture):
    """Seen from above, x points right and y up the page."""
    figure = draw_capture(scene_capture, "capture", NONE)
    names = [(a.get_xlabel(), a.get_ylabel()) for a in figure.axes]
    assert ("x [m]", "y [m]") in names
    y_down = turned(scene_capture, [[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    figure = draw_capture(y_down, "capture", NONE)
    names = [(a.get_xlabel(), a.get_ylabel()) for a in figure.axes]
    assert ("x [m]", "z [m]") in names
