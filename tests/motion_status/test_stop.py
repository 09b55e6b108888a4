"""The part or the point that a supervisor's stop concerns."""

import dataclasses as dc
from functools import partial

import numpy as np
import pytest
from held_robot import SHELF, drive
from pydrake.math import RigidTransform

from remosplat_drake.motion_status.hold import Hold, beside_mover
from remosplat_drake.motion_status.stop import find_stop
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals import motion_status as states
from remosplat_drake.signals import supervisor_state as stops
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.binding import MOVER
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.supervisor_state import STOPPED, SupervisorState
from remosplat_drake.signals.thing import SOLID, Thing
from remosplat_drake.signals.tick_report import TickReport

P_WC = np.array([1.0, 2.0, 3.0])
CAN = Thing(SOLID, "the can")
ARM, BASE, HAND = "panda_link0", "base_link", "panda_hand"


def stop_of(robot, symptom: str, axis: int | None = None) -> Hold:
    """The place of a stop, with the hand 9 mm from a can."""
    hand = robot.spheres.links.index(HAND)
    near = Clearances(
        np.array([hand]), np.array([0.009]), np.eye(3)[:1], P_WC[None]
    )
    X_WT = np.eye(4)
    X_WT[:3, 3] = 4.0, 5.0, 6.0
    report = dc.replace(
        TickReport.before_first(robot.n_q, robot.n_u),
        clearances=near,
        aim=Aim.of(X_WT),
    )
    state = SupervisorState(np.zeros(robot.n_u), STOPPED, "why")
    state = dc.replace(state, symptom=symptom, axis=axis)
    return find_stop(state, report, robot, lambda p_W: CAN)


@pytest.mark.parametrize(
    "symptom, axis, cause, link",
    [
        (stops.SCANNER, None, states.BASE, BASE),
        (stops.LOST, None, states.LOCALIZATION, BASE),
        (stops.ARM_MODE, None, states.SUPERVISOR, ARM),
        (stops.ARM_RATE, None, states.SUPERVISOR, ARM),
        ("follow", 0, states.SUPERVISOR, BASE),
        ("follow", 1, states.SUPERVISOR, BASE),
        ("tracking", 2, states.SUPERVISOR, "panda_link1"),
        ("bounds", 8, states.SUPERVISOR, "panda_link7"),
        (stops.ASKED, None, states.SUPERVISOR, ""),
        ("clock", None, states.SUPERVISOR, ""),
    ],
)
def test_the_part_that_a_stop_concerns(frankie, symptom, axis, cause, link):
    stop = stop_of(frankie, symptom, axis)
    assert (stop.cause, stop.link, stop.p_W) == (cause, link, None)


def test_what_is_too_near_is_the_place_of_a_stop(frankie):
    stop = stop_of(frankie, stops.CLEARANCE)
    assert (stop.cause, stop.thing) == (states.SUPERVISOR, "the can")
    assert (stop.link, stop.clearance) == (HAND, 0.009)
    np.testing.assert_array_equal(stop.p_W, P_WC)


def test_a_target_that_jumps_is_the_place_of_a_stop(frankie):
    stop = stop_of(frankie, stops.JUMP)
    assert stop.link == ""
    np.testing.assert_array_equal(stop.p_W, [4.0, 5.0, 6.0])


def test_a_fixed_arm_has_no_base_to_show():
    assert stop_of(load_robot("panda"), stops.SCANNER).link == ""


def test_the_place_of_a_mover_is_on_it_before_the_link(frankie):
    q = frankie.q_home
    spheres = frankie.spheres_at(q)
    hand = spheres.p_WS[frankie.spheres.on_links({HAND})]
    p_W = hand.mean(axis=0) + np.array([0.0, 0.4, 0.0])
    ada = Mover("Ada", RigidTransform(p_W), np.zeros(3), 0.1)
    other = dc.replace(ada, name="Bob", X_WM=RigidTransform(hand[0]))
    place = partial(
        beside_mover, robot=frankie, q=q, movers=Movers(0.0, (other, ada))
    )
    hold = place(Hold(MOVER, "Ada", HAND), time=0.0)
    assert hold.p_W is not None
    assert np.linalg.norm(hold.p_W - p_W) == pytest.approx(0.1, abs=1e-6)
    # It is on the side of the hand.
    assert hold.p_W[1] < p_W[1] - 0.09
    unknown = Hold(MOVER, "Eve", HAND)
    assert place(unknown, time=0.0) is unknown
    can = Hold(SOLID, "the can", HAND, P_WC)
    assert place(can, time=0.0) is can


def test_a_run_that_stops_shows_the_arm(tmp_path):
    text = "{supervisor: {robot_modes: [guiding]}}"
    status = drive(tmp_path, [0.45, 0.1, 0.4], SHELF, text=text).motion_status
    assert (status.kind, status.link) == (states.STOPPED, ARM)
