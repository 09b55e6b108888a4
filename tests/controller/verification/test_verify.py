"""The fraction of a command that the map allows."""

import dataclasses as dc
import itertools
import math

import numpy as np
import pytest
from effort import effort
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RotationMatrix
from verified_commands import Around, at, verified_command
from verify_reference import least_margins

from remosplat_drake.controller.verification.kernels.between_samples import (
    TOLERANCE,
    longest_way,
    tolerated,
)
from remosplat_drake.controller.verification.kernels.verified import SCALES
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.braking import executed_command
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import SphereModel
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

STOPPING = 0.02
DT = 0.1


class Slab(SignedDistanceField):
    """Everything below a height; counts the spheres it is asked about."""

    def __init__(self, top: float):
        box = Box(RigidTransform([0, 0, top - 5]), np.array([9.0, 9.0, 5.0]))
        super().__init__(PrimitiveScene(boxes=(box,)))
        self.asked = 0

    def clearances(self, spheres, max_distance=np.inf):
        self.asked += len(spheres)
        return super().clearances(spheres, max_distance)


class Unsure(SignedDistanceField):
    """The same answers, without the promise that they are distances."""

    is_lipschitz = False


@pytest.fixture(scope="module")
def pendulum(three_link) -> RobotModel:
    """One sphere of radius 0.1 m, 0.5 m from the shoulder."""
    sphere = SphereModel(
        "ball", ("upper_arm",), np.array([[0.5, 0, 0]]), np.array([0.1])
    )
    return RobotModel(three_link.description, sphere)


def around(
    robot,
    field,
    q,
    *,
    stopping=STOPPING,
    dt=DT,
    limit=np.inf,
    bound=None,
    self_clearance=None,
):
    """Surroundings at q; without a limit the robot stops at once."""
    state = robot.state(np.array(q, float))
    clearance = field.clearances(state.spheres).per_sphere(len(state.spheres))
    return Around(
        robot,
        field,
        state,
        clearance if bound is None else bound,
        stopping,
        dt,
        np.broadcast_to(np.asarray(limit, float), (robot.n_u,)),
        self_clearance,
    )


def scale_of(robot, field, q, u, **settings) -> float:
    u = np.array(u, float)
    return verified_command(
        around(robot, field, q, **settings), u, np.zeros_like(u)
    )[1]


def descent(scale: float, rate: float = 1.0) -> float:
    """How far the ball falls from the horizontal until a station has braked."""
    return 0.5 * np.sin(1.5 * scale * rate * DT)


@pytest.mark.parametrize("scale", SCALES)
def test_the_first_fraction_that_keeps_the_distance_is_taken(pendulum, scale):
    # The ball starts with just as much room as this fraction needs.
    room = descent(scale) + 1e-9
    field = Slab(1.0 - 0.1 - STOPPING - room)
    assert scale_of(pendulum, field, [0, 0, 0], [1, 0, 0]) == scale


def test_no_fraction_fits_where_there_is_no_room(pendulum):
    room = 0.9 * descent(SCALES[-1])
    field = Slab(1.0 - 0.1 - STOPPING - room)
    assert scale_of(pendulum, field, [0, 0, 0], [1, 0, 0]) == 0.0


def test_moving_away_is_free(pendulum):
    field = Slab(1.0 - 0.1 - STOPPING)
    assert scale_of(pendulum, field, [0, 0, 0], [-1, 0, 0]) == 1.0


def test_a_sphere_that_is_too_close_may_not_come_closer(pendulum):
    # 5 mm away although 20 mm are wanted: it may leave, not approach.
    field = Slab(1.0 - 0.1 - 0.005)
    assert scale_of(pendulum, field, [0, 0, 0], [1, 0, 0]) == 0.0
    assert scale_of(pendulum, field, [0, 0, 0], [-1, 0, 0]) == 1.0


def test_a_penetrating_sphere_may_leave(pendulum):
    field = Slab(1.0 - 0.1 + 0.03)
    assert scale_of(pendulum, field, [0, 0, 0], [1, 0, 0]) == 0.0
    assert scale_of(pendulum, field, [0, 0, 0], [-1, 0, 0]) == 1.0


def test_standing_still_is_allowed_anywhere(pendulum):
    for top in (0.0, 0.88, 0.9, 1.0, 1.2):
        assert scale_of(pendulum, Slab(top), [0, 0, 0], [0, 0, 0]) == 1.0


def test_far_spheres_are_not_asked_about(three_link):
    field = Slab(0.0)
    here = around(three_link, field, np.zeros(3), limit=10.0)
    field.asked = 0
    _, scale, _ = verified_command(here, 0.3 * np.ones(3), np.zeros(3))
    assert (field.asked, scale) == (0, 1.0)


def test_a_lower_bound_of_far_clearances_is_enough(three_link):
    """As the controller does: clearances are known up to the influence."""
    bound = np.full(len(three_link.spheres), 0.5)
    assert scale_of(three_link, Slab(0.0), np.zeros(3), np.ones(3), bound=bound)


@given(
    seed=st.integers(0, 1000),
    joint=st.tuples(*[st.floats(-1, 1)] * 9),
    ahead=st.floats(0.0, 0.6),
)
@settings(max_examples=effort(20, 40))
def test_a_true_distance_allows_no_more_than_what_is_none(
    frankie, seed, joint, ahead
):
    scene = generate("table" if seed % 2 else "bookshelf", seed)
    q = np.array([ahead, *scene.X_WB_start[1:], *frankie.home])
    u = np.array(joint) * frankie.velocity_limit
    scales = [
        scale_of(frankie, field(scene), q, u)
        for field in (SignedDistanceField, Unsure)
    ]
    # It is asked between the ends of ticks, too.
    assert scales[0] <= scales[1]


@given(
    seed=st.integers(0, 1000),
    joint=st.tuples(*[st.floats(-1, 1)] * 9),
    ahead=st.floats(0.0, 0.6),
)
@settings(max_examples=effort(20, 40))
def test_the_scaled_command_keeps_every_sphere_clear(
    frankie, seed, joint, ahead
):
    scene = generate("table" if seed % 2 else "bookshelf", seed)
    field = SignedDistanceField(scene)
    q = np.array([ahead, *scene.X_WB_start[1:], *frankie.home])
    u = np.array(joint) * frankie.velocity_limit
    q_next = frankie.advance(q, scale_of(frankie, field, q, u) * u, DT)
    n = len(frankie.spheres)
    before = field.clearances(frankie.spheres_at(q)).per_sphere(n)
    after = field.clearances(frankie.spheres_at(q_next)).per_sphere(n)
    assert (after >= np.minimum(STOPPING, before) - 1e-12).all()


@pytest.mark.filterwarnings("ignore:invalid value")
def test_a_map_that_knows_nothing_allows_nothing(pendulum):
    class Unknown(Unsure):
        def clearances(self, spheres, max_distance=np.inf):
            known = super().clearances(spheres)
            return dc.replace(known, distance=np.full(len(known), np.nan))

    box = Box(RigidTransform([0, 0, -5]), np.array([9.0, 9.0, 5.0]))
    field = Unknown(PrimitiveScene(boxes=(box,)))
    here = around(pendulum, field, np.zeros(3), bound=np.ones(1))
    _, scale, _ = verified_command(here, np.array([1.0, 0, 0]), np.zeros(3))
    assert scale == 0.0


def test_the_braking_distance_counts(pendulum):
    # At 1 rad/s and 2 rad/s^2, after 0.15 s the station's ramp goes on at 0.8,
    # 0.6, 0.4, 0.2: 0.35 rad in all, although the tick ends at 0.1 rad.
    fall = 0.5 * np.sin(0.35)
    enough = Slab(1.0 - 0.1 - STOPPING - fall - 1e-9)
    short = Slab(1.0 - 0.1 - STOPPING - fall + 1e-6)
    settings = {"limit": 2.0}
    assert scale_of(pendulum, enough, [0, 0, 0], [1, 0, 0], **settings) == 1.0
    assert scale_of(pendulum, short, [0, 0, 0], [1, 0, 0], **settings) < 1.0


def test_a_refused_command_gives_way_to_the_braking_ramp(pendulum):
    # Falling at 1 rad/s with room for no more than the ramp: 0.8 rad/s next.
    u = np.array([1.0, 0.0, 0.0])
    room = 0.5 * np.sin(0.2)
    field = Slab(1.0 - 0.1 - STOPPING - room - 1e-9)
    here = around(pendulum, field, [0, 0, 0], limit=2.0)
    command, scale, _ = verified_command(here, u, u)
    assert scale == 0.0
    np.testing.assert_allclose(command, [0.8, 0, 0])


@given(
    seed=st.integers(0, 1000),
    joint=st.tuples(*[st.floats(-1, 1)] * 9),
    before=st.tuples(*[st.floats(-1, 1)] * 9),
)
@settings(max_examples=effort(15, 30))
def test_tried_commands_keep_the_acceleration_bounds(
    frankie, seed, joint, before
):
    scene = generate("table" if seed % 2 else "bookshelf", seed)
    q = np.array([0.3, *scene.X_WB_start[1:], *frankie.home])
    limit, dt = frankie.acceleration_limit, 0.02
    u_previous = np.array(before) * frankie.velocity_limit
    u = u_previous + np.array(joint) * limit * dt
    here = around(frankie, SignedDistanceField(scene), q, limit=limit, dt=dt)
    command, _, _ = verified_command(here, u, u_previous)
    assert (np.abs(command - u_previous) <= limit * dt * (1 + 1e-9)).all()


# Between the ends of ticks


def post(x: float, z: float, radius: float = 0.001) -> SignedDistanceField:
    """A thin bar across the plane in which the pendulum swings."""
    X_WP = RigidTransform(
        RotationMatrix.MakeXRotation(np.pi / 2), np.array([x, 0.0, z])
    )
    return SignedDistanceField(
        PrimitiveScene(cylinders=(Cylinder(X_WP, radius, 1.0),))
    )


def test_a_sphere_does_not_jump_over_a_post_within_a_tick(pendulum):
    # The ball of radius 0.1 m swings on a circle of 0.5 m around (0, 1): 60
    # degrees in one tick. At half of it, the post stands in its way; at both
    # ends the ball is 0.5 m * 2 sin(15 deg) - 0.1 m = 159 mm from it.
    half = math.radians(30)
    field = post(0.5 * math.cos(half), 1.0 - 0.5 * math.sin(half))
    u = np.array([2 * half / DT, 0.0, 0.0])
    for q in (np.zeros(3), np.array([2 * half, 0.0, 0.0])):
        ball = pendulum.spheres_at(q)
        assert field.clearances(ball).minimum() == pytest.approx(
            0.158, abs=2e-3
        )
    assert scale_of(pendulum, field, np.zeros(3), u) < 1.0


@pytest.mark.parametrize(("excess", "allowed"), [(0.8, True), (1.1, False)])
def test_within_a_tick_half_a_millimetre_is_tolerated(
    pendulum, excess, allowed
):
    # A post beside the arc, nearest to it half-way: there the ball comes
    # nearer than it may by a share of the tolerance.
    half = math.radians(10)
    far = 0.5 + 0.1 + 0.001 + STOPPING - excess * TOLERANCE
    field = post(far * math.cos(half), 1.0 - far * math.sin(half))
    u = np.array([2 * half / DT, 0.0, 0.0])
    assert (scale_of(pendulum, field, np.zeros(3), u) == 1.0) is allowed


def test_what_is_tolerated_does_not_add_up():
    for below, least in ((-1.0, 5e-4), (0.0, 5e-4), (2e-4, 3e-4), (5e-4, 0.0)):
        assert tolerated(STOPPING - below, STOPPING) == pytest.approx(least)
    # A robot that started too near has nothing to lose but its level.
    assert tolerated(STOPPING - 6e-4, STOPPING) == TOLERANCE


def test_what_is_no_distance_is_asked_at_the_ends_of_ticks_only(pendulum):
    """The weaker promise of depth views."""
    half = math.radians(30)
    field = post(0.5 * math.cos(half), 1.0 - 0.5 * math.sin(half))
    field.is_lipschitz = False
    u = np.array([2 * half / DT, 0.0, 0.0])
    assert scale_of(pendulum, field, np.zeros(3), u) == 1.0


_BAND = 2e-5
"""Between samples at every 200th of a tick a margin falls by no more [m]."""


@pytest.mark.parametrize("dt", [0.02, 0.1])
@given(
    seed=st.integers(0, 1000),
    joint=st.tuples(*[st.floats(-1, 1)] * 9),
    ahead=st.floats(0.0, 0.6),
)
@settings(max_examples=effort(3, 15))
def test_it_allows_what_looking_very_often_allows(
    frankie, frankie_itself, dt, seed, joint, ahead
):
    scene = generate("table" if seed % 2 else "bookshelf", seed)
    q = np.array([ahead, *scene.X_WB_start[1:], *frankie.home])
    # Along a step of the acceleration limits, so that the ramp is short.
    u = np.array(joint) * frankie.acceleration_limit * 0.1
    u /= max(1.0, (np.abs(u) / frankie.velocity_limit).max())
    here = around(
        frankie,
        SignedDistanceField(scene),
        q,
        dt=dt,
        limit=frankie.acceleration_limit,
        self_clearance=frankie_itself,
    )
    at_ends, at_all_times = least_margins(here, u)
    _, scale, _ = verified_command(here, u, np.zeros(9))
    if scale == 1.0:
        assert at_ends >= -1e-12
        assert at_all_times >= -1e-12
    elif not beyond_limits(frankie, here, u):
        assert at_ends <= 1e-12 or at_all_times <= _BAND


def beyond_limits(robot, here, u) -> bool:
    path = here.path(u)
    end = at(path, path.times[-1:])[0]
    return bool(
        (end > robot.position_upper).any() or (end < robot.position_lower).any()
    )


# The robot itself


@pytest.fixture(scope="module")
def frankie_itself(frankie) -> SelfClearance:
    return SelfClearance.make(frankie, 0.01)


def test_the_ramp_stays_within_joint_limits(three_link):
    q = np.zeros(3)
    q[1] = three_link.position_upper[1] - 0.25
    u = np.array([0.0, 1.0, 0.0])
    # A tick of 0.1 rad, which a station may hold by half as long again, and a
    # ramp of 0.08 + 0.06 + 0.04 + 0.02 rad.
    field, limit = Slab(-9.0), np.full(3, 2.0)
    assert scale_of(three_link, field, q, u, limit=limit) < 1.0
    q[1] -= 0.11
    assert scale_of(three_link, field, q, u, limit=limit) == 1.0


def test_a_joint_beyond_its_limit_may_only_come_back(three_link):
    q = np.zeros(3)
    q[1] = three_link.position_upper[1] + 0.1
    field = Slab(-9.0)
    assert scale_of(three_link, field, q, [0, 0.1, 0]) == 0.0
    assert scale_of(three_link, field, q, [0, -0.1, 0]) == 1.0
    assert scale_of(three_link, field, q, [0.1, 0, 0]) == 1.0


class Table:
    """Frankie beside a table, and the distances that it must keep there."""

    def __init__(self, robot: RobotModel, itself: SelfClearance):
        scene = generate("table", 3)
        self.robot, self.itself = robot, itself
        self.field = SignedDistanceField(scene)
        self.q = np.array([0.3, *scene.X_WB_start[1:], *robot.home])
        self.level = np.minimum(STOPPING, self.around(self.q, DT).clearance)
        self.self_level = np.minimum(0.01, itself.distances(self.q))

    def around(self, q, dt: float) -> Around:
        limit, itself = self.robot.acceleration_limit, self.itself
        return around(
            self.robot, self.field, q, dt=dt, limit=limit, self_clearance=itself
        )

    def check(self, q, slack: float) -> None:
        """Fails if something is nearer by more than the slack."""
        spheres = self.robot.spheres_at(q)
        found = self.field.clearances(spheres).per_sphere(len(spheres))
        assert (found >= self.level - slack).all()
        assert (self.itself.distances(q) >= self.self_level - slack).all()
        assert (q >= self.robot.position_lower - 1e-9).all()
        assert (q <= self.robot.position_upper + 1e-9).all()


@pytest.fixture(scope="module")
def table(frankie, frankie_itself) -> Table:
    return Table(frankie, frankie_itself)


@pytest.mark.parametrize("dt", [0.01, 0.05, 0.1])
def test_random_commands_keep_all_that_is_promised(frankie, table, dt):
    """At full speed here and there, seen five times a tick."""
    rng = np.random.default_rng(round(1e3 * dt))
    limit, q = frankie.acceleration_limit, table.q
    u, refused = np.zeros(9), 0
    for tick in range(round(effort(2.0, 5.0) / dt)):
        if tick % round(0.5 / dt) == 0:
            goal = rng.choice([-1, -0.5, 0.5, 1], 9) * frankie.velocity_limit
        wanted = np.clip(goal, u - limit * dt, u + limit * dt)
        u, scale, _ = verified_command(table.around(q, dt), wanted, u)
        refused += scale < 1.0
        for share in np.linspace(0.2, 1.0, 5):
            slack = 1e-9 if share == 1.0 else TOLERANCE
            table.check(frankie.advance(q, u, share * dt), slack)
        q = frankie.advance(q, u, dt)
    assert refused > 0


@pytest.mark.parametrize("dt", [0.01, 0.05])
def test_nothing_creeps_where_commands_come_when_they_like(frankie, table, dt):
    """After 0.2 to 11 periods; the station holds a command, then brakes."""
    rng = np.random.default_rng(round(1e3 * dt))
    limit, q = frankie.acceleration_limit, table.q
    u, age, refused = np.zeros(9), 1.0, 0
    for tick in range(effort(200, 800)):
        if tick % round(1.0 / dt) == 0:
            goal = rng.choice([-1, -0.5, 0.5, 1], 9) * frankie.velocity_limit
        executed = executed_command(u, limit, dt, age * dt)
        wanted = np.clip(goal, executed - limit * dt, executed + limit * dt)
        u, scale, _ = verified_command(table.around(q, dt), wanted, u, age)
        refused += scale < 1.0
        age = rng.choice([rng.uniform(0.2, 1.6), rng.uniform(0.2, 11.0)])
        ends = np.append(np.arange(1.5, age), age)
        for begin, end in itertools.pairwise(np.append(0.0, ends)):
            v = executed_command(u, limit, dt, 0.5 * (begin + end) * dt)
            for share in (0.5, 1.0):
                at = frankie.advance(q, v, share * (end - begin) * dt)
                table.check(at, TOLERANCE + 1e-9)
            q = at
    assert refused > 0


def test_reach_bounds_every_jacobian(frankie):
    rng = np.random.default_rng(0)
    lower, upper = frankie.position_lower[3:], frankie.position_upper[3:]
    for _ in range(50):
        q = np.array([*rng.uniform(-1, 1, 3), *rng.uniform(lower, upper)])
        speeds = np.linalg.norm(frankie.state(q).Jv_WS, axis=1)
        assert (speeds <= frankie.jacobian_bound + 1e-12).all()


def test_bend_bounds_every_change_of_velocity(frankie, three_link):
    rng = np.random.default_rng(0)
    h = 1e-4
    for robot in (frankie, three_link):
        arm = slice(robot.n_q - len(robot.home), None)
        lower, upper = robot.position_lower[arm], robot.position_upper[arm]
        for _ in range(50):
            base = rng.uniform(-1, 1, robot.n_q - len(robot.home))
            q = np.array([*base, *rng.uniform(lower, upper)])
            u = rng.uniform(-1, 1, robot.n_u)
            a, b, c = (
                robot.spheres_at(robot.advance(q, u, t)).p_WS
                for t in (-h, 0.0, h)
            )
            change = np.linalg.norm(a - 2 * b + c, axis=1) / h**2
            bound = robot.hessian_bound @ np.abs(u) @ np.abs(u)
            assert (change <= bound + 1e-6).all()


@given(
    seed=st.integers(0, 1000),
    time=st.floats(0.01, 0.5),
    joint=st.tuples(*[st.floats(-1, 1)] * 9),
)
@settings(max_examples=effort(15, 30))
def test_no_sphere_travels_farther_than_its_bound(frankie, seed, time, joint):
    q = np.array([0, 0, 0, *frankie.home])
    u = np.array(joint) * frankie.velocity_limit
    path = frankie.advance_for(q, u, np.linspace(0.0, time, 200))
    p_WS = np.array([frankie.spheres_at(state).p_WS for state in path])
    way = np.linalg.norm(np.diff(p_WS, axis=0), axis=2).sum(axis=0)
    bend = frankie.hessian_bound @ np.abs(u) @ np.abs(u)
    for i in range(len(way)):
        bound = longest_way(p_WS[0, i], p_WS[-1, i], bend[i], time)
        assert way[i] <= bound + 1e-12
