"""The link that is held, and the place, light up."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.signals.motion_status import (
    ENDED,
    HELD,
    MOVING,
    REACHED,
    STOPPED,
    STOPPING,
    MotionStatus,
)
from remosplat_drake.visualization.motion_status_view import (
    LINKS,
    PLACE,
    MotionStatusView,
    draw_end,
)
from remosplat_drake.visualization.page_state import unsupervised

GLOW = f"{LINKS}/panda_hand"
P_W = np.array([0.9, 0.1, 0.3])
HELD_HAND = MotionStatus(HELD, "hand held", 0.5, link="panda_hand", p_W=P_W)


@pytest.fixture
def show(page, frankie):
    """A function that shows how things stand."""
    dut = MotionStatusView(page=page, robot=frankie)

    def show(status: MotionStatus):
        context = dut.CreateDefaultContext()
        dut.GetInputPort("configuration").FixValue(context, frankie.q_home)
        dut.GetInputPort("motion_status").FixValue(context, Value(status))
        dut.ForcedPublish(context)

    return show


def test_a_robot_that_moves_has_no_lights(show, page):
    show(MotionStatus(MOVING, "on its way", 0.5))
    assert not page.meshcat.HasPath(LINKS)
    assert not page.meshcat.HasPath(PLACE)


def test_link_and_place_light_up(show, page, frankie, pose_of, is_visible):
    show(HELD_HAND)
    assert is_visible(page.meshcat, GLOW) and is_visible(page.meshcat, PLACE)
    X_WL = frankie.body_poses(frankie.q_home)[frankie.tree.index("panda_hand")]
    np.testing.assert_allclose(pose_of(page.meshcat, GLOW), X_WL, atol=1e-12)
    X = pose_of(page.meshcat, PLACE)
    np.testing.assert_allclose(X[:3, 3], P_W)
    # The ring faces the hand.
    spheres = frankie.spheres_at(frankie.q_home)
    p_WS = spheres.p_WS[frankie.spheres.on_links({"panda_hand"})]
    away = p_WS[np.linalg.norm(p_WS - P_W, axis=1).argmin()] - P_W
    np.testing.assert_allclose(X[:3, 2], away / np.linalg.norm(away))


@pytest.mark.parametrize("kind", (STOPPING, STOPPED))
def test_what_a_stop_is_about_lights_up(show, page, is_visible, kind):
    show(MotionStatus(kind, "protective stop of the base", link="base_link"))
    assert is_visible(page.meshcat, f"{LINKS}/base_link")
    assert not page.meshcat.HasPath(PLACE)
    show(MotionStatus(kind, "too near", link="panda_hand", p_W=P_W))
    assert not is_visible(page.meshcat, f"{LINKS}/base_link")
    assert is_visible(page.meshcat, GLOW) and is_visible(page.meshcat, PLACE)


def test_at_the_end_what_holds_the_robot_stays_lit(page, frankie, is_visible):
    builder = DiagramBuilder()
    view = MotionStatusView.AddToBuilder(builder, page=page, robot=frankie)
    for name in ("configuration", "motion_status"):
        builder.ExportInput(view.GetInputPort(name), name)
    diagram = builder.Build()
    ended = dc.replace(HELD_HAND, kind=ENDED, text="time limit: hand held")
    draw_end(diagram, ended, frankie.q_home, 1.0)
    assert is_visible(page.meshcat, GLOW) and is_visible(page.meshcat, PLACE)
    draw_end(diagram, MotionStatus(REACHED, "reached"), frankie.q_home, 1.0)
    assert not is_visible(page.meshcat, GLOW)
    assert not is_visible(page.meshcat, PLACE)


def test_the_lights_go_out(show, page, is_visible):
    show(HELD_HAND)
    show(MotionStatus(HELD, "elbow held", 0.5, link="panda_link4"))
    assert is_visible(page.meshcat, f"{LINKS}/panda_link4")
    assert not is_visible(page.meshcat, GLOW)
    assert not is_visible(page.meshcat, PLACE)
    show(MotionStatus(MOVING, "on its way", 0.5))
    assert not is_visible(page.meshcat, f"{LINKS}/panda_link4")


def test_without_a_supervisor_the_bar_says_it(show, page):
    page.show(unsupervised())
    show(HELD_HAND)
    assert page.state == unsupervised(HELD_HAND)
    assert page.state.text == "hand held"
