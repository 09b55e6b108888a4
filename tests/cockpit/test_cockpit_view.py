"""The messages to the cockpit, without a cockpit."""

import dataclasses as dc
from types import SimpleNamespace

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.teleop_session import camera_maker
from remosplat_drake.app.world import load_world
from remosplat_drake.cockpit.cockpit_operator import CockpitOperator
from remosplat_drake.cockpit.cockpit_view import CockpitView, page_content
from remosplat_drake.cockpit.messages import (
    CockpitRequests,
    MapPicture,
    PageContent,
)
from remosplat_drake.cockpit.operator_input import SOURCE
from remosplat_drake.cockpit.viewpoints import HAND, TOP, VIEWS, viewpoint
from remosplat_drake.cockpit.wrist_pictures import wrist_pictures
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.coverage import Coverage
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.motion_status import (
    HELD,
    NOT_STARTED,
    MotionStatus,
)
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.operator_requests import OperatorRequests
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.signals.supervisor_state import STOPPED, SupervisorState
from remosplat_drake.signals.target_state import FOLLOW, TargetState
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization import page_state as pages
from remosplat_drake.visualization.page_state import RELEASE, STOP


@pytest.fixture(scope="module")
def frankie():
    return load_robot("frankie")


def content(frankie, **changes) -> PageContent:
    parts = {
        "motion_status": NOT_STARTED,
        "target": TargetState.at_rest(np.eye(4), "hold: start"),
        "supervision": None,
        "status": None,
    } | changes
    return page_content(1.0, frankie.q_home, frankie, **parts)


def test_who_is_held_is_told_with_the_place(frankie):
    p_W = np.array([0.5, 0.1, 0.7])
    held = MotionStatus(HELD, "hand held", link="panda_hand", p_W=p_W)
    told = content(frankie, motion_status=held)
    assert told.held_link == "panda_hand" and told.p_WHeld is p_W
    assert told.state.title == "Held" and told.state.text == "hand held"
    stopped = content(frankie, motion_status=dc.replace(held, kind="stopped"))
    assert (stopped.held_link, stopped.cause) == ("panda_hand", "")
    assert stopped.p_WHeld is p_W
    moving = dc.replace(held, kind="moving")
    assert content(frankie, motion_status=moving).held_link == ""
    assert content(frankie, motion_status=moving).p_WHeld is None


def test_a_stopped_robot_may_be_released_by_its_operator(frankie):
    state = SupervisorState(np.zeros(9), mode=STOPPED, reason="stop button")
    told = content(frankie, supervision=state)
    assert told.state.buttons == (STOP, RELEASE)
    assert told.state.text == "stop button"
    # Without a supervisor nothing stops, and no button pretends to.
    assert content(frankie).state.buttons == ()


def test_a_robot_without_a_map_is_not_green(frankie):
    field = SignedDistanceField(PrimitiveScene())
    moving = MotionStatus("moving", "moving to the target")
    nothing = GaussianSplat.empty()
    blank = MapStatus(SceneMap(0, None, (), -np.inf, field, nothing))
    told = content(frankie, motion_status=moving, status=blank).state
    assert (told.phase, told.title) == (pages.HELD, "Live, without a map")
    assert told.text == "scan first; moving to the target"
    disc = GaussianSplat(
        p_GK=np.zeros((1, 3)),
        quaternions=np.eye(4)[:1],
        scales=np.full((1, 2), 0.1),
        opacities=np.ones(1),
        colors=np.ones((1, 3)),
    )
    known = dc.replace(blank.scene_map, splat_W=disc)
    told = content(frankie, motion_status=moving, status=MapStatus(known)).state
    assert told.phase == pages.LIVE


@pytest.mark.parametrize(
    ("mode", "source", "followed"),
    [(FOLLOW, SOURCE, True), (FOLLOW, "gamepad", False), ("go", SOURCE, False)],
)
def test_only_a_target_that_follows_the_cockpit_is_left_alone(
    frankie, mode, source, followed
):
    target = dc.replace(
        TargetState.at_rest(np.eye(4)),
        mode=mode,
        command=OperatorCommand(source=source),
    )
    assert content(frankie, target=target).is_followed is followed


class FakeProcess:
    """Keeps what it is told."""

    def __init__(self):
        self.looks, self.maps = [], []
        self.requests, self.trouble = CockpitRequests(), ""
        self.show, self.show_map = self.looks.append, self.maps.append


def test_a_map_is_told_once(frankie):
    process = FakeProcess()
    scene_map, later = (
        SceneMap(version, None, (), 0.0, SignedDistanceField(PrimitiveScene()))
        for version in range(2)
    )
    view = CockpitView(
        process=process,
        robot=frankie,
        initial=scene_map,
        picture=MapPicture(scene_map.field, None, None, True),
        period=0.01,
    )
    context = view.CreateDefaultContext()

    def fix(name: str, value):
        view.GetInputPort(name).FixValue(context, value)

    fix("configuration", frankie.q_home)
    fix("motion_status", Value(NOT_STARTED))
    fix("target_state", Value(TargetState.at_rest(np.eye(4))))
    for shown in (scene_map, scene_map, later, later):
        fix("map_status", Value[object](MapStatus(shown, text="a map")))
        view._publish(context)
    assert len(process.looks) == 4 and len(process.maps) == 1
    assert process.maps[0].field is later.field
    assert process.maps[0].shows_unseen
    assert process.looks[-1].map == "a map"


def test_a_static_map_is_told_again_when_an_object_was_found_in_it(frankie):
    """What cameras have seen of it stays."""
    process, field = FakeProcess(), SignedDistanceField(PrimitiveScene())
    first, rest = (SceneMap(0, None, (), -np.inf, field) for _ in range(2))
    seen = Coverage(np.zeros(3), 0.1, np.zeros((2, 2, 2), np.uint8))
    view = CockpitView(
        process=process,
        robot=frankie,
        initial=first,
        picture=MapPicture(field, None, seen, True),
        period=0.01,
    )
    context = view.CreateDefaultContext()
    for name, value in (
        ("configuration", frankie.q_home),
        ("motion_status", Value(NOT_STARTED)),
        ("target_state", Value(TargetState.at_rest(np.eye(4)))),
    ):
        view.GetInputPort(name).FixValue(context, value)
    for shown in (first, first, rest, rest):
        port = view.GetInputPort("scene_map")
        port.FixValue(context, Value[object](shown))
        view._publish(context)
    (told,) = process.maps
    assert told.field is rest.field and told.coverage is seen


def test_the_operator_asks_what_was_asked_last():
    process = SimpleNamespace(
        requests=CockpitRequests(), trouble="", silence=0.0
    )
    operator = CockpitOperator(process=process)
    context = operator.CreateDefaultContext()

    def asked(name: str):
        context.SetTime(context.get_time() + 0.01)
        return operator.GetOutputPort(name).Eval(context)

    assert asked("operator").stops == 0
    process.requests = CockpitRequests(
        command=OperatorCommand(holds=2), operator=OperatorRequests(stops=3)
    )
    assert asked("command").holds == 2 and asked("operator").stops == 3
    process.trouble = "the cockpit's process has ended"
    assert asked("operator") == OperatorRequests(
        3, 0, "the cockpit's process has ended"
    )


def test_pictures_show_the_scene_that_the_camera_sees(frankie):
    """A wall that is put before it, and is gone in the next picture."""
    small = "{wrist_camera: {width: 80, height: 60}}"
    scenario = load_scenario("StudioLive", small)
    world = load_world(scenario, blank=True)
    now = content(frankie)
    X_WP = RigidTransform(now.X_WE) @ RigidTransform([0.0, 0.0, 0.25])
    wall = PrimitiveScene(boxes=(Box(X_WP, np.array([1.0, 1.0, 0.01])),))
    job = SimpleNamespace(
        make_camera=camera_maker(scenario, world, hardware=False),
        scenes=(world.truth, wall),
    )
    changes = 0
    pictures = wrist_pictures(job, lambda: (now, changes))
    first = next(pictures).depth
    changes = 1
    walled = next(pictures).depth
    changes = 2
    again = next(pictures).depth
    assert np.nanmax(walled) < 0.5 < np.nanmax(first)
    np.testing.assert_array_equal(first, again)


@pytest.mark.parametrize("view", VIEWS)
def test_views_look_at_something_from_somewhere_else(frankie, view):
    at = viewpoint(view, content(frankie))
    sight = at.p_WT - at.p_WC
    assert np.linalg.norm(sight) > 0.3
    # A camera that looks along its own up has no picture.
    assert np.linalg.norm(np.cross(sight, at.up_W)) > 1e-2
    assert at.p_WC[2] > 0.2 or view == HAND


def test_from_the_top_ahead_is_up(frankie):
    at = viewpoint(TOP, content(frankie))
    np.testing.assert_allclose(at.up_W, [1, 0, 0], atol=1e-9)
