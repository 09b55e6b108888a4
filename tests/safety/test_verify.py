"""Which fraction of a command the map allows."""

import dataclasses as dc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform

from remosplat_drake.benchmark.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import SphereModel
from remosplat_drake.safety.verify import (
    SCALES,
    Surroundings,
    verified_command,
)
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

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
    robot, field, q, *, stopping=STOPPING, dt=DT, limit=np.inf, bound=None
):
    """Surroundings at q; without a limit the robot stops at once."""
    state = robot.state(np.array(q, float))
    clearance = field.clearances(state.spheres).per_sphere(len(state.spheres))
    return Surroundings(
        robot,
        field,
        state,
        clearance if bound is None else bound,
        stopping,
        dt,
        np.broadcast_to(np.asarray(limit, float), (robot.n_u,)),
    )


def scale_of(robot, field, q, u, **settings) -> float:
    u = np.array(u, float)
    return verified_command(
        around(robot, field, q, **settings), u, np.zeros_like(u)
    )[1]


def descent(scale: float, rate: float = 1.0) -> float:
    """How far the ball falls from the horizontal."""
    return 0.5 * np.sin(scale * rate * DT)


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
    _, scale = verified_command(here, 0.3 * np.ones(3), np.zeros(3))
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
@settings(max_examples=40, deadline=None)
def test_skipping_far_spheres_changes_no_answer(frankie, seed, joint, ahead):
    scene = generate("table" if seed % 2 else "bookshelf", seed)
    q = np.array([ahead, *scene.X_WB_start[1:], *frankie.home])
    u = np.array(joint) * frankie.velocity_limit
    scales = [
        scale_of(frankie, field(scene), q, u)
        for field in (SignedDistanceField, Unsure)
    ]
    assert scales[0] == scales[1]


@given(
    seed=st.integers(0, 1000),
    joint=st.tuples(*[st.floats(-1, 1)] * 9),
    ahead=st.floats(0.0, 0.6),
)
@settings(max_examples=40, deadline=None)
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
    _, scale = verified_command(here, np.array([1.0, 0, 0]), np.zeros(3))
    assert scale == 0.0


def test_the_braking_distance_counts(pendulum):
    # At 1 rad/s and 2 rad/s^2, after the tick of 0.1 s the ramp goes on at
    # 0.8, 0.6, 0.4, 0.2: 0.3 rad in all, although the tick ends at 0.1 rad.
    fall = 0.5 * np.sin(0.3)
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
    command, scale = verified_command(here, u, u)
    assert scale == 0.0
    np.testing.assert_allclose(command, [0.8, 0, 0])


@given(
    seed=st.integers(0, 1000),
    joint=st.tuples(*[st.floats(-1, 1)] * 9),
    before=st.tuples(*[st.floats(-1, 1)] * 9),
)
@settings(max_examples=30, deadline=None)
def test_tried_commands_keep_the_acceleration_bounds(
    frankie, seed, joint, before
):
    scene = generate("table" if seed % 2 else "bookshelf", seed)
    q = np.array([0.3, *scene.X_WB_start[1:], *frankie.home])
    limit, dt = frankie.acceleration_limit, 0.02
    u_previous = np.array(before) * frankie.velocity_limit
    u = u_previous + np.array(joint) * limit * dt
    here = around(frankie, SignedDistanceField(scene), q, limit=limit, dt=dt)
    command, _ = verified_command(here, u, u_previous)
    assert (np.abs(command - u_previous) <= limit * dt * (1 + 1e-9)).all()


def test_reach_bounds_every_jacobian(frankie):
    rng = np.random.default_rng(0)
    lower, upper = frankie.position_lower[3:], frankie.position_upper[3:]
    for _ in range(50):
        q = np.array([*rng.uniform(-1, 1, 3), *rng.uniform(lower, upper)])
        speeds = np.linalg.norm(frankie.state(q).Jv_WS, axis=1)
        assert (speeds <= frankie.reach + 1e-12).all()
