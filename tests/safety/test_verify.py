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
from remosplat_drake.safety.verify import SCALES, safe_scale
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


def scale_of(robot, field, q, u, *, stopping=STOPPING, dt=DT) -> float:
    state = robot.state(np.array(q, float))
    clearance = field.clearances(state.spheres).per_sphere(len(state.spheres))
    return safe_scale(
        robot, field, state, np.array(u, float), dt, stopping, clearance
    )


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
    q, u = np.zeros(3), np.ones(3)
    state = three_link.state(q)
    clearance = field.clearances(state.spheres).per_sphere(len(state.spheres))
    field.asked = 0
    safe_scale(three_link, field, state, u, DT, STOPPING, clearance)
    assert field.asked == 0


def test_a_lower_bound_of_far_clearances_is_enough(three_link):
    """As the controller does: clearances are known up to the influence."""
    field = Slab(0.0)
    state = three_link.state(np.zeros(3))
    bound = np.full(len(state.spheres), 0.5)
    u = np.ones(3)
    assert safe_scale(three_link, field, state, u, DT, STOPPING, bound) == 1.0


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
    state = pendulum.state(np.zeros(3))
    u, far = np.array([1.0, 0, 0]), np.ones(1)
    assert safe_scale(pendulum, field, state, u, DT, STOPPING, far) == 0.0
