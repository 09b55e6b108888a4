"""The causes that hold a robot, in ticks that are worked out by hand."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.base.kernels import kernel
from remosplat_drake.controller.ingredients.kernels.assemble import OUTSIDE
from remosplat_drake.controller.program.kernels.binding_arrays import (
    binding_arrays,
)
from remosplat_drake.controller.program.kernels.outside import joined
from remosplat_drake.controller.program.kernels.tick_arrays import make_program
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.tick.run_tick import named_binding
from remosplat_drake.controller.tick.tick_program import RowNames
from remosplat_drake.motion_status.hold import find_hold, find_inside, pressures
from remosplat_drake.robot.self_collision.hull_distance_reference import (
    signed_distance,
)
from remosplat_drake.robot.self_collision.pairs import self_collision_pairs
from remosplat_drake.signals import motion_status as states
from remosplat_drake.signals.binding import (
    BOUND,
    COLLISION,
    JOINT_LIMIT,
    SELF_COLLISION,
    Binding,
    BoundRow,
)
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.thing import SOLID, Thing
from remosplat_drake.signals.tick_report import (
    BRAKING,
    OPTIMAL,
    TickReport,
)

CAN = Thing(SOLID, "the can")


def wants(*u: float) -> ReactiveProgram:
    """A program whose cost alone is least at u: |u - wanted|^2 / 2."""
    program = ReactiveProgram(np.full(len(u), 1.0))
    program.add_quadratic_cost("quadratic", np.ones(len(u)))
    program.add_linear_cost("linear", -np.array(u))
    return program


def find_binding(program: ReactiveProgram, u: np.ndarray) -> Binding:
    """The rows that hold with equality at the optimum of a program."""
    arrays = _binding_of(program.arrays, u)
    return named_binding(arrays, RowNames((), None, None, program))


@kernel
def _binding_of(outside, u):
    nothing = make_program(outside.bounds[1].copy(), 0, OUTSIDE + 1, 0)
    return binding_arrays(joined(nothing, outside), u)


def test_a_wall_bears_what_pushes_against_it():
    program = wants(0.5, 0.3)
    program.add_rows(
        "wall", np.array([[2.0, 0.0]]), np.array([0.4]), lambda i: ("a", "b")
    )
    program.add_rows("idle", np.array([[0.0, 1.0]]), np.array([0.9]))
    binding = find_binding(program, np.array([0.2, 0.3]))
    assert binding.rows == (BoundRow("wall", 0, ("a", "b")),)
    # The wish along x that is left over; along y nothing is.
    np.testing.assert_allclose(binding.push, [0.3, 0.0], atol=1e-12)
    np.testing.assert_allclose(pressures(binding), [0.3])


def test_a_wall_that_is_only_touched_bears_nothing():
    program = wants(0.5, 0.0)
    walls = np.array([[1.0, 0.0], [0.0, 1.0]])
    program.add_rows("walls", walls, np.array([0.2, 0.0]))
    binding = find_binding(program, np.array([0.2, 0.0]))
    assert len(binding.rows) == 2
    np.testing.assert_allclose(pressures(binding), [0.3, 0.0], atol=1e-12)


def test_a_bound_on_the_command_bears_its_share():
    program = wants(0.5, 3.0)
    program.add_rows("wall", np.array([[1.0, 0.0]]), np.array([0.2]))
    binding = find_binding(program, np.array([0.2, 1.0]))
    assert [row.name for row in binding.rows] == ["wall", BOUND]
    np.testing.assert_allclose(pressures(binding), [0.3, 2.0])


def test_a_free_robot_is_not_looked_at_twice():
    program = wants(0.5)
    binding = find_binding(program, np.array([0.5]))
    assert not binding.rows
    assert not len(pressures(binding))


def report_of(robot, rows=(), pushes=(), **changes) -> TickReport:
    """A tick at home in which each row, along an axis of its own, bears."""
    k = len(rows)
    A = np.eye(robot.n_u)[:k]
    push = np.zeros(robot.n_u)
    push[:k] = pushes
    report = TickReport.before_first(robot.n_q, robot.n_u)
    return dc.replace(
        report,
        q=robot.q_home,
        status=OPTIMAL,
        reason="",
        clearances=clearances_of(robot),
        binding=Binding(tuple(rows), A, push),
        **changes,
    )


def clearances_of(robot) -> Clearances:
    """The hand 21 mm and the base 30 mm from something."""
    links = robot.spheres.links
    sphere = np.array([links.index("panda_hand"), links.index("base_link")])
    p_WC = np.array([[1.0, 2.0, 3.0], [0.0, 0.0, 0.3]])
    distance = np.array([0.021, 0.030])
    return Clearances(sphere, distance, np.tile([1.0, 0, 0], (2, 1)), p_WC)


HAND = BoundRow(COLLISION, 0, ())
BASE = BoundRow(COLLISION, 1, ())


def name(p_W: np.ndarray) -> Thing:
    return CAN


def test_a_link_before_a_thing(frankie):
    hold = find_hold(
        report_of(frankie, [BASE, HAND], [0.1, 1.0]), frankie, name
    )
    assert (hold.cause, hold.thing) == (SOLID, "the can")
    assert (hold.link, hold.clearance) == ("panda_hand", 0.021)
    np.testing.assert_array_equal(hold.p_W, [1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    "pushes, link", [((0.9, 1.0), "base_link"), ((0.4, 1.0), "panda_hand")]
)
def test_two_that_hold_together_do_not_take_turns(frankie, pushes, link):
    report = report_of(frankie, [BASE, HAND], pushes)
    assert find_hold(report, frankie, name, "base_link").link == link


def test_a_joint_at_its_limit(frankie):
    q = frankie.q_home.copy()
    k = frankie.joint_names.index("panda_joint4")
    q[k] = frankie.position_lower[k] + 0.17
    row = BoundRow(JOINT_LIMIT, 0, ("panda_joint4",))
    report = dc.replace(report_of(frankie, [row], [1.0]), q=q)
    hold = find_hold(report, frankie, name)
    assert hold.cause == states.JOINT_LIMIT
    assert hold.thing == "the lower limit of joint 4"
    assert hold.link == "panda_link4"
    X_WL = frankie.body_poses(q)[frankie.tree.index("panda_link4")]
    np.testing.assert_array_equal(hold.p_W, X_WL[:3, 3])


@pytest.mark.parametrize("order", (1, -1))
def test_the_robot_before_itself(frankie, order):
    links = ("base_link", "panda_hand")[::order]
    row = BoundRow(SELF_COLLISION, 0, links)
    hold = find_hold(report_of(frankie, [row], [1.0]), frankie, name)
    assert (hold.cause, hold.link) == (states.SELF_COLLISION, "panda_hand")
    assert hold.thing == "the base"
    shapes = self_collision_pairs(frankie, 0.0).shapes
    X_WL = frankie.body_poses(frankie.q_home)
    hand, base = (
        [
            (s.vertices @ X[:3, :3].T + X[:3, 3], s.radius)
            for s in shapes.of(link)
        ]
        for link in ("panda_hand", "base_link")
        for X in [X_WL[frankie.tree.index(link)]]
    )
    apart = min(signed_distance(p, o) - r - t for p, r in hand for o, t in base)
    assert hold.clearance == pytest.approx(apart, abs=1e-4)
    # The place is on the hand, and so far from the base.
    assert hold.p_W is not None
    place = hold.p_W[None]
    off = min(signed_distance(place, o) - t for o, t in base)
    assert off == pytest.approx(apart, abs=1e-4)


def test_a_constraint_of_another_package(frankie):
    row = BoundRow("leash", 0, ("dog",))
    hold = find_hold(report_of(frankie, [row], [1.0]), frankie, name)
    assert (hold.cause, hold.thing) == (states.CONSTRAINT, "leash (dog)")


def test_nothing_holds_who_wants_nothing(frankie):
    for report in (
        report_of(frankie),
        report_of(frankie, [HAND], [1e-6]),
        report_of(frankie, [BoundRow(BOUND, 0, ())], [5.0]),
    ):
        assert find_hold(report, frankie, name).cause == states.NOTHING


def test_a_robot_that_stands_although_it_is_told_to_move(frankie):
    told = dc.replace(report_of(frankie), command=np.full(9, 0.1))
    assert find_hold(told, frankie, name).cause == states.NOT_OBEYED


def test_verification_is_afraid_of_the_nearest(frankie):
    report = report_of(frankie, objection=COLLISION)
    hold = find_hold(dc.replace(report, scale=0.0), frankie, name)
    assert (hold.cause, hold.thing) == (states.VERIFICATION, "the can")
    assert (hold.link, hold.clearance) == ("panda_hand", 0.021)
    # A row that lets the robot go does not hold it.
    assert find_hold(report, frankie, name).cause == states.NOTHING


@pytest.mark.parametrize(
    "objection, thing",
    [(JOINT_LIMIT, "a joint's limit"), (SELF_COLLISION, "the robot itself")],
)
def test_verification_is_afraid_of_the_robot(frankie, objection, thing):
    report = report_of(frankie, objection=objection)
    hold = find_hold(dc.replace(report, scale=0.0), frankie, name)
    assert (hold.cause, hold.thing) == (states.VERIFICATION, thing)


def test_there_is_no_command(frankie):
    report = dc.replace(
        report_of(frankie), status=BRAKING, reason="target is not finite"
    )
    hold = find_hold(report, frankie, name)
    assert (hold.cause, hold.thing) == (
        states.NO_COMMAND,
        "target is not finite",
    )


def test_what_is_most_inside_is_named_although_something_else_holds(frankie):
    report = report_of(frankie, [BASE], [1.0], inside=HAND)
    inside = find_inside(report, frankie, name)
    assert inside is not None
    assert (inside.thing, inside.link) == ("the can", "panda_hand")
    assert inside.clearance == 0.021
    assert find_hold(report, frankie, name).link == "base_link"


def test_nothing_is_inside(frankie):
    assert find_inside(report_of(frankie, [HAND], [1.0]), frankie, name) is None
