"""One sentence for every way in which things may stand."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.controller.guidance.selection import Selection
from remosplat_drake.controller.planning.plan import (
    CRAMPED,
    CUT_OFF,
    UNREACHED,
)
from remosplat_drake.controller.program.guidance import DIRECT
from remosplat_drake.motion_status.hold import Hold
from remosplat_drake.motion_status.sentence import (
    CIRCLING,
    Situation,
    at_end,
    describe_motion,
)
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.signals import motion_status as states
from remosplat_drake.signals import supervisor_state as modes
from remosplat_drake.signals import thing as things
from remosplat_drake.signals.motion_status import MotionStatus
from remosplat_drake.signals.supervisor_state import SupervisorState
from remosplat_drake.signals.target import Target
from remosplat_drake.task.target_sequence import TargetProgress


def error(distance: float, degrees: float = 0.0) -> PoseError:
    """So far away along x, turned about z."""
    p = np.array([distance, 0.0, 0.0])
    return PoseError(p, np.radians([0.0, 0.0, degrees]), p)


def supervision(
    mode: str, reason: str = "", refusal: str = "", symptom: str = ""
):
    return SupervisorState(np.zeros(9), mode, reason, refusal, symptom)


FAR = Situation(error(0.52), progress=TargetProgress(0, 1))
SECOND = dc.replace(FAR, progress=TargetProgress(1, 2))
ROUND = 21e-3 * np.array([1.0, 0.0, 0.0])


def held(cause: str, thing: str = "", link: str = "", clearance=None, **known):
    hold = Hold(cause, thing, link, ROUND, clearance)
    return dc.replace(FAR, hold=hold, **known)


HAND = "panda_hand"
SENTENCES = {
    "moving to the target, 0.52 m away": FAR,
    "moving to target 2 of 2, 0.52 m away": SECOND,
    "moving to the target, 41 mm and 12 deg away": Situation(error(0.041, 12)),
    "moving to the target, 0.52 m away, no nearer for 12 s": dc.replace(
        FAR, no_nearer_for=CIRCLING + 2
    ),
    "moving past target 2 of 2, 0.52 m away": dc.replace(
        SECOND, target=Target(np.eye(4), passed_within=0.1)
    ),
    "on the line to the target, 0.52 m away, 3 mm beside the line": dc.replace(
        FAR,
        target=Target(np.eye(4)).on_line(np.eye(4), 0.1),
        beside_line=0.003,
    ),
    "moving to the target, 41 mm away": Situation(
        error(0.041), Target(np.eye(4)).without("rx", "ry", "rz")
    ),
    "moving to the target, 12 deg away": Situation(
        error(0.0, 12), Target(np.eye(4)).without("x", "y", "z")
    ),
    "job 2 of 3: robot lifts the can, 0.52 m away": dc.replace(
        FAR, progress=TargetProgress(1, 3, "lifts the can")
    ),
    "job 2 of 3: robot opens its hand": Situation(
        error(0.0),
        is_there=True,
        progress=TargetProgress(1, 3, "opens its hand"),
    ),
    "gave up: lifts the can: too near": dc.replace(
        FAR,
        progress=TargetProgress(
            1, 3, "lifts the can", "lifts the can: too near"
        ),
    ),
    "reached": dc.replace(FAR, progress=TargetProgress(1, 1)),
    "reached all 2": dc.replace(FAR, progress=TargetProgress(2, 2)),
    "at the target": Situation(error(0.004), is_there=True),
    "waiting for the first control tick": Situation(error(np.nan)),
    "waiting for the first measurement": dc.replace(
        FAR,
        supervision=supervision(
            modes.STARTING, "waiting for the first measurement"
        ),
    ),
    modes.UNARMED: dc.replace(
        FAR, supervision=supervision(modes.STOPPED, modes.UNARMED)
    ),
    "stopping: stop button": dc.replace(
        FAR, supervision=supervision(modes.STOPPING, "stop button")
    ),
    "stopped: stop button; waiting for an operator, 0.52 m from target 2 of"
    " 2": dc.replace(
        SECOND, supervision=supervision(modes.STOPPED, "stop button")
    ),
    "stopped: stop button; waiting for an operator, 0.52 m from the target;"
    " not released: protective stop of the base": dc.replace(
        FAR,
        supervision=supervision(
            modes.STOPPED,
            "stop button",
            "not released: protective stop of the base",
        ),
    ),
    "hand held 21 mm from unseen space, 0.52 m from the target: add a frame"
    " that sees it": held(things.UNSEEN, "unseen space", HAND, 0.021),
    "elbow held 3 mm inside the shelf, 0.52 m from the target: move or turn"
    " the target": held(things.SOLID, "the shelf", "panda_link4", -0.003),
    "base held 30 mm from the map's surface, 0.52 m from the target: move or"
    " turn the target": held(
        things.MAP, things.THE_MAP.name, "base_link", 0.030
    ),
    "elbow held at the lower limit of joint 4, 0.52 m from the target: turn"
    " the target": held(
        states.JOINT_LIMIT, "the lower limit of joint 4", "panda_link4"
    ),
    "hand held 10 mm from the base, 0.52 m from the target: turn the"
    " target": held(states.SELF_COLLISION, "the base", HAND, 0.010),
    "moving to the target, 0.52 m away: it is 0.30 m out of reach, move it"
    " nearer": dc.replace(FAR, beyond=0.3, no_nearer_for=CIRCLING + 2),
    "robot stands still, 0.52 m from the target: it is 0.30 m out of reach,"
    " move it nearer": held(states.NOTHING, beyond=0.3),
    "moving to the target, 0.52 m away: it is 0.30 m out of reach, the base is"
    " not allowed to drive: move it nearer": dc.replace(
        FAR, beyond=0.3, parked=True
    ),
    "robot stands still, 0.52 m from the target: the base is not allowed to"
    " drive: move it nearer": held(states.NOTHING, parked=True),
    "robot stands still, 0.52 m from the target; no configuration": held(
        states.NOTHING,
        selection=Selection(
            DIRECT, unreachable="no configuration", lack=UNREACHED
        ),
    ),
    "moving out: hand 5 mm from the base, 0.52 m from the target": dc.replace(
        FAR, inside=Hold(states.SELF_COLLISION, "the base", HAND, ROUND, 0.005)
    ),
    "moving out: elbow beyond the upper limit of joint 4, 0.52 m from the"
    " target": dc.replace(
        FAR,
        inside=Hold(
            states.JOINT_LIMIT, "the upper limit of joint 4", "panda_link4"
        ),
    ),
    "no motion away from it found: hand 31 mm inside the base, 0.52 m from"
    " the target": held(
        states.NOTHING,
        inside=Hold(states.SELF_COLLISION, "the base", HAND, ROUND, -0.031),
    ),
    "hand waits for Ada, 0.52 m from the target: it continues when that has"
    " passed": held(states.MOVER, "Ada", HAND),
    "robot held by leash (dog), 0.52 m from the target": held(
        states.CONSTRAINT, "leash (dog)"
    ),
    "hand held 22 mm from the floor, 0.52 m from the target: there would be no"
    " way to stop in time": held(states.VERIFICATION, "the floor", HAND, 0.022),
    "braking: target is not finite, 0.52 m from the target": held(
        states.NO_COMMAND, "target is not finite"
    ),
    "robot is commanded to move and stands still, 0.52 m from the target: see"
    " whether the robot is enabled": held(states.NOT_OBEYED),
    "robot stands still, 0.52 m from the target: nothing is in the way, it may"
    " be out of reach": held(states.NOTHING),
    "hand held 21 mm from the can, 0.52 m from the target: move or turn the"
    " target; no path found": held(
        things.SOLID,
        "the can",
        HAND,
        0.021,
        selection=Selection(DIRECT, unreachable="no path found"),
    ),
    "hand held 21 mm from the can, 0.52 m from the target: move or turn the"
    " target; all lack 3 mm": held(
        things.SOLID,
        "the can",
        HAND,
        0.021,
        selection=Selection(
            DIRECT, unreachable="all lack 3 mm; move or turn the target"
        ),
    ),
    "hand held 21 mm from the can, 0.52 m from the target: move or turn the"
    " target; guidance has found no way": held(
        things.SOLID,
        "the can",
        HAND,
        0.021,
        selection=Selection(DIRECT, hopeless_at=np.zeros(10)),
    ),
}


@pytest.mark.parametrize("text", sorted(SENTENCES))
def test_the_sentence(text, frankie):
    status = describe_motion(SENTENCES[text], frankie.description)
    assert status.text == text
    assert status.kind in states.KINDS
    assert status.cause in ("", *states.CAUSES)


def test_the_parts_of_a_sentence(frankie):
    now = held(things.SOLID, "the can", HAND, 0.021)
    status = describe_motion(now, frankie.description)
    assert status.document() == {
        "kind": states.HELD,
        "text": status.text,
        "distance": 0.52,
        "cause": things.SOLID,
        "thing": "the can",
        "link": HAND,
        "p_W": [0.021, 0.0, 0.0],
        "clearance": 0.021,
        "way": "",
    }
    assert states.NOT_STARTED.document()["distance"] is None


@pytest.mark.parametrize(
    "now, cause",
    [
        (dc.replace(FAR, beyond=0.3), states.NO_CONFIGURATION),
        (dc.replace(FAR, beyond=0.3, parked=True), states.BASE),
        (held(states.JOINT_LIMIT, beyond=0.3), states.NO_CONFIGURATION),
        (held(states.NOTHING, parked=True), states.BASE),
        (held(states.JOINT_LIMIT, parked=True), states.JOINT_LIMIT),
        *(
            (
                held(
                    states.NOTHING,
                    selection=Selection(
                        DIRECT, unreachable="none found", lack=lack
                    ),
                ),
                cause,
            )
            for lack, cause in (
                (UNREACHED, states.NO_CONFIGURATION),
                (CRAMPED, states.NO_CONFIGURATION),
                (CUT_OFF, states.NO_PATH),
                ("", states.NOTHING),
            )
        ),
        *(
            (dc.replace(FAR, supervision=supervision(mode), stop=stop), cause)
            for mode in (modes.STOPPING, modes.STOPPED)
            for stop, cause in (
                (None, states.SUPERVISOR),
                (Hold(states.BASE), states.BASE),
            )
        ),
    ],
)
def test_the_cause(now, cause, frankie):
    now = dc.replace(now, target=Target(np.eye(4)))
    status = describe_motion(now, frankie.description)
    assert status.cause == cause
    is_lit = cause in (states.BASE, states.NO_CONFIGURATION, states.NO_PATH)
    if is_lit and now.supervision is None:
        assert status.p_W is not None


def test_a_stop_goes_before_all_else(frankie):
    stopped = supervision(modes.STOPPED, "stop button")
    now = held(things.SOLID, "the can", HAND, 0.021, supervision=stopped)
    status = describe_motion(now, frankie.description)
    assert (status.kind, status.link) == (states.STOPPED, "")
    assert status.p_W is None


@pytest.mark.parametrize("mode", (modes.STOPPING, modes.STOPPED))
def test_a_stop_has_a_place(mode, frankie):
    stop = Hold(states.SUPERVISOR, "the can", HAND, ROUND, 0.009)
    now = dc.replace(FAR, supervision=supervision(mode, "near"), stop=stop)
    status = describe_motion(now, frankie.description)
    assert status.is_obstructed and status.p_W is ROUND
    assert (status.link, status.clearance) == (HAND, 0.009)


@pytest.mark.parametrize(
    "kind", (states.REACHED, states.STOPPED, states.WAITING)
)
def test_the_end_says_what_was_said_before(kind):
    status = MotionStatus(kind, "as it was")
    assert at_end(status, "time limit") is status


def test_targets_of_others_know_where_they_end(frankie):
    end = at_end(describe_motion(FAR, frankie.description), "reached")
    assert (end.kind, end.text) == (states.REACHED, "reached")


def test_the_end_of_a_robot_that_is_held(frankie):
    now = held(things.SOLID, "the can", HAND, 0.021)
    end = at_end(describe_motion(now, frankie.description), "time limit")
    assert end.kind == states.ENDED
    assert end.text == (
        "time limit: hand held 21 mm from the can, 0.52 m from the target:"
        " move or turn the target"
    )
    assert (end.cause, end.link) == (things.SOLID, HAND)
    assert at_end(end, "interrupted") is end


def test_other_numbers_are_no_news(frankie):
    def said(thing: str, clearance: float) -> MotionStatus:
        now = held(things.SOLID, thing, HAND, clearance)
        return describe_motion(now, frankie.description)

    assert not said("the can", 0.021).is_news_after(said("the can", 0.022))
    assert said("the can", 0.021).is_news_after(said("the box", 0.021))
    assert said("the can", 0.021).is_news_after(states.NOT_STARTED)


@pytest.mark.parametrize(
    "name, called",
    [
        ("panda_link4", "elbow"),
        ("panda_joint4", "joint 4"),
        ("panda_hand", "hand"),
        ("some_other_link12", "some other link 12"),
    ],
)
def test_names_that_people_use(frankie, name, called):
    assert frankie.description.called(name) == called


@pytest.mark.parametrize("name", ("frankie", "panda"))
def test_every_named_link_exists(name):
    robot = load_robot(name)
    assert set(robot.description.link_names) <= set(robot.tree.names)
