"""Each cost and constraint: a case worked by hand, then the general truth.

The three-link arm at q = 0 lies along the world's x axis at z = 1: shoulder
at x = 0, elbow at x = 0.5, wrist at x = 0.9. A positive rate of its first
two joints lowers all links further out.
"""

import dataclasses as dc
import math

import numpy as np
import pytest
from programs import program_of
from reference_ingredients import bodies_of

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.ranges import check_ranges
from remosplat_drake.controller import ingredients as ing
from remosplat_drake.controller.ingredients.manipulability_cost import (
    manipulability,
)
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.tick.tick_program import TickProgram
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.self_collision.pairs import self_collision_pairs
from remosplat_drake.signals.distance_field import Clearances

STEP = 1e-6
FOREARM = 3
"""The sphere on the forearm, 0.1 m beyond the elbow."""


def added(ingredient, tick) -> TickProgram:
    return program_of(tick, [ingredient])


def linear_cost(program: TickProgram) -> np.ndarray:
    (c,) = program.terms.linear.values()
    np.testing.assert_array_equal(program.form.c[: program.n_u], c)
    return c


def one_row(sphere: int, distance: float, direction_W) -> Clearances:
    return Clearances(
        np.array([sphere]),
        np.array([distance]),
        np.array([direction_W], float),
        np.zeros((1, 3)),
    )


def random_state(robot, rng) -> tuple[np.ndarray, np.ndarray]:
    """A configuration near home, and a command."""
    q = np.array([*rng.uniform(-0.3, 0.3, 3), *robot.home])
    q[3:] += rng.uniform(-0.3, 0.3, len(robot.home))
    return q, rng.uniform(-0.5, 0.5, robot.n_u)


def rate_along(robot, f, q, u):
    """df/dt while the command u is held, by central differences."""
    ahead = f(robot.advance(q, u, STEP))
    return (ahead - f(robot.advance(q, u, -STEP))) / (2 * STEP)


# Servo tracking


def test_servo_tracking_asks_for_the_twist(three_link, make_tick):
    tick = make_tick(three_link, [0.3, -0.8, 0.2])
    program = added(
        ing.ServoTracking(
            ing.ServoTrackingConfig(gain=2.0), ing.CollisionDamperConfig()
        ),
        tick,
    )
    A = program.form.J
    np.testing.assert_allclose(A[:3, :3], tick.state.Jw_WE)
    np.testing.assert_allclose(A[3:, :3], tick.state.Jv_WE)
    np.testing.assert_allclose(A[:, 3:], np.eye(6))
    # The target is 0.1 m up.
    np.testing.assert_allclose(program.form.V, [0, 0, 0, 0, 0, 0.2], atol=1e-12)


def test_the_slack_grows_dear_near_the_target(three_link, make_tick):
    state = three_link.state(np.zeros(3))
    for distance, e in ((0.1, 0.1), (0.0, 1e-3)):
        X_WT = state.X_WE.copy()
        # One axis of E, so that the L1 norm is the distance.
        X_WT[:3, 3] += distance * state.X_WE[:3, 1]
        tick = make_tick(three_link, np.zeros(3), X_WT=X_WT)
        program = added(
            ing.ServoTracking(
                ing.ServoTrackingConfig(), ing.CollisionDamperConfig()
            ),
            tick,
        )
        np.testing.assert_allclose(program.form.Q[3:, 3:], np.eye(6) / e)


def test_standing_still_is_feasible_however_far_the_target_is_turned(
    three_link, make_tick
):
    X_WT = three_link.end_effector_pose(np.zeros(3))
    X_WT[:3, :3] = X_WT[:3, :3] @ np.diag([1.0, -1, -1])
    tick = make_tick(three_link, np.zeros(3), X_WT=X_WT)
    config = ing.ServoTrackingConfig(gain=4.0, slack_limit=10.0)
    program = added(
        ing.ServoTracking(config, ing.CollisionDamperConfig()), tick
    )
    V_WE = program.form.V
    assert np.abs(V_WE).max() > config.slack_limit
    x = np.concatenate([np.zeros(3), V_WE])
    assert program.prog.CheckSatisfied(program.prog.GetAllConstraints(), x)


# Velocity cost and limits


def test_the_base_is_cheap_far_from_the_target(frankie, make_tick):
    q = np.array([0, 0, 0, *frankie.home])
    X_WT = frankie.end_effector_pose(q)
    X_WT[:3, 3] += 0.5 * X_WT[:3, 2]
    tick = make_tick(frankie, q, X_WT=X_WT)
    program = added(ing.VelocityCost(ing.VelocityCostConfig(weight=0.02)), tick)
    np.testing.assert_allclose(
        program.form.Q, np.diag([0.04, 0.04] + [0.02] * 7)
    )


def test_to_a_configuration_paths_alone_lead(frankie, make_tick):
    tick = make_tick(frankie, frankie.q_home)
    aim = dc.replace(tick.aim, q=tick.state.q)
    tick = dc.replace(tick, aim=aim)
    tracking = ing.ServoTracking(
        ing.ServoTrackingConfig(), ing.CollisionDamperConfig()
    )
    assert not len(added(tracking, tick).form.J)
    # At its target, too, the base is as cheap as 100 m away from it.
    cost = added(ing.VelocityCost(ing.VelocityCostConfig(weight=0.3)), tick)
    (weights,) = cost.terms.quadratic.values()
    assert weights == pytest.approx([0.003] * 2 + [0.3] * 7)


def test_velocity_limits_are_a_fraction_of_the_robots(three_link, make_tick):
    config = ing.VelocityLimitsConfig(fraction=0.5, acceleration=False)
    program = added(
        ing.VelocityLimits(config), make_tick(three_link, np.zeros(3))
    )
    np.testing.assert_allclose(program.lower, [-1, -1, -1])
    np.testing.assert_allclose(program.upper, [1, 1, 1])
    assert not program.has_acceleration_bounds


def test_the_base_may_be_slower_backwards(frankie, make_tick):
    u = np.zeros(frankie.n_u)
    u[0] = -0.4
    tick = make_tick(frankie, np.array([0, 0, 0, *frankie.home]), u_previous=u)
    config = ing.VelocityLimitsConfig(max_reverse=0.25)
    program = added(ing.VelocityLimits(config), tick)
    # 0.25 m/s, and 1 m/s^2 for 0.01 s from there.
    np.testing.assert_allclose(program.lower[0], -0.25)
    np.testing.assert_allclose(program.upper[0], -0.24)
    np.testing.assert_allclose(-program.lower[1:], program.upper[1:])


def test_the_base_may_be_slower_than_it_could(frankie, make_tick):
    tick = make_tick(frankie, np.array([0, 0, 0, *frankie.home]))
    config = ing.VelocityLimitsConfig(
        max_forward=0.1, max_yaw_rate=0.2, acceleration=False
    )
    program = added(ing.VelocityLimits(config), tick)
    limit = frankie.velocity_limit
    np.testing.assert_allclose(program.lower, [-limit[0], -0.2, *-limit[2:]])
    np.testing.assert_allclose(program.upper, [0.1, 0.2, *limit[2:]])


def test_a_robot_without_a_base_has_no_bounds_for_one(three_link, make_tick):
    config = ing.VelocityLimitsConfig(max_forward=0.1, max_yaw_rate=0.1)
    tick = make_tick(three_link, np.zeros(3))
    program = added(ing.VelocityLimits(config), tick)
    assert (program.upper > 0.0999).all()
    free = added(ing.VelocityLimits(ing.VelocityLimitsConfig()), tick)
    np.testing.assert_array_equal(program.upper, free.upper)


def test_acceleration_bounds_surround_the_previous_command(
    three_link, make_tick
):
    # At most 10 rad/s^2 for 0.01 s from (0, 1, 1.95), and 2 rad/s.
    tick = make_tick(three_link, np.zeros(3), u_previous=[0, 1, 1.95])
    program = added(ing.VelocityLimits(ing.VelocityLimitsConfig()), tick)
    np.testing.assert_allclose(program.lower, [-0.1, 0.9, 1.85])
    np.testing.assert_allclose(program.upper, [0.1, 1.1, 2])
    assert program.has_acceleration_bounds


def test_a_previous_command_beyond_the_limits_leaves_room(
    three_link, make_tick
):
    tick = make_tick(three_link, np.zeros(3), u_previous=[3, -3, 0])
    config = ing.VelocityLimitsConfig(fraction=0.5)
    program = added(ing.VelocityLimits(config), tick)
    np.testing.assert_allclose(program.lower, [0.95, -1, -0.05])
    np.testing.assert_allclose(program.upper, [1, -0.95, 0.05])


@pytest.mark.parametrize("fraction", [0.1, 0.5, 1.0])
def test_a_fraction_of_the_limits_is_one_of_the_accelerations_too(
    three_link, make_tick, fraction
):
    tick = make_tick(three_link, np.zeros(3))
    config = ing.VelocityLimitsConfig(fraction=fraction)
    program = added(ing.VelocityLimits(config), tick)
    # 10 rad/s^2 for 0.01 s.
    np.testing.assert_allclose(program.upper, np.full(3, 0.1 * fraction))


def test_acceleration_bounds_can_be_dropped(three_link, make_tick):
    program = added(
        ing.VelocityLimits(ing.VelocityLimitsConfig()),
        make_tick(three_link, np.zeros(3)),
    )
    np.testing.assert_allclose(program.arrays.free_upper, [2, 2, 2])
    np.testing.assert_allclose(program.arrays.free_lower, [-2, -2, -2])


# Joint limits


@pytest.mark.parametrize("side", [1, -1])
def test_a_joint_near_its_limit_is_slowed(three_link, make_tick, side):
    # The shoulder's limits are +-2 rad. 20 degrees before one of them the
    # damper allows (20 - 10) / (50 - 10) of its gain towards it.
    tick = make_tick(three_link, [side * (2 - math.radians(20)), 0, 0])
    config = ing.JointLimitDamperConfig(gain=2.0, influence=50, stop=10)
    rows = added(ing.JointLimitDamper(config), tick).terms.rows["joint limit"]
    np.testing.assert_array_equal(rows.A, [[side, 0, 0]])
    np.testing.assert_allclose(rows.b, [0.5])


def test_a_joint_in_the_stop_zone_must_retreat(three_link, make_tick):
    tick = make_tick(three_link, [0, math.radians(2) - 2.5, 0])
    rows = added(
        ing.JointLimitDamper(ing.JointLimitDamperConfig()), tick
    ).terms.rows["joint limit"]
    np.testing.assert_array_equal(rows.A, [[0, -1, 0]])
    np.testing.assert_allclose(rows.b, [-1.0])


def test_a_joint_far_from_its_limits_is_free(three_link, make_tick):
    damper = ing.JointLimitDamper(ing.JointLimitDamperConfig())
    assert not added(damper, make_tick(three_link, np.zeros(3))).terms.rows


@pytest.mark.parametrize("side", [1, -1])
def test_a_slide_near_its_limit_is_slowed_in_metres(lift_arm, make_tick, side):
    # The lift travels from 0 to 0.35 m. 4 cm before one of its ends the
    # damper allows (4 - 1) / (10 - 1) of 0.3 m/s towards it.
    lift = 0.31 if side > 0 else 0.04
    tick = make_tick(lift_arm, [lift, 0, 0, 0])
    config = ing.JointLimitDamperConfig(
        slide_gain=0.3, slide_influence=0.1, slide_stop=0.01
    )
    rows = added(ing.JointLimitDamper(config), tick).terms.rows["joint limit"]
    np.testing.assert_array_equal(rows.A, [[side, 0, 0, 0]])
    np.testing.assert_allclose(rows.b, [0.1])
    assert rows.about(0) == ("lift",)


def test_a_slide_is_free_in_the_middle_of_its_range(lift_arm, make_tick):
    damper = ing.JointLimitDamper(ing.JointLimitDamperConfig())
    assert not added(damper, make_tick(lift_arm, [0.175, 0, 0, 0])).terms.rows


def test_distances_are_a_share_of_the_range_at_most(lift_arm, make_tick):
    # The lift: a third and a tenth of 0.35 m. The shoulder: of 4 rad.
    config = ing.JointLimitDamperConfig(
        influence=180, stop=90, slide_influence=1, slide_stop=0.5
    )
    np.testing.assert_allclose(
        config.influence_of(lift_arm)[:2], [0.35 / 3, 4 / 3]
    )
    # The bound is zero at the stopping distance; guidance may set another.
    paths = Guidance(joint_stop=0.1, slide_stop=0.002)
    for guidance, lift, shoulder in (
        (Guidance(), 0.035, 0.4),
        (paths, 0.002, math.radians(0.1)),
    ):
        tick = make_tick(lift_arm, [lift, 2.0 - shoulder, 0, 0])
        tick = dc.replace(tick, guidance=guidance)
        rows = added(ing.JointLimitDamper(config), tick).terms.rows[
            "joint limit"
        ]
        for joint, sign in ((0, -1), (1, 1)):
            (row,) = np.flatnonzero(rows.A[:, joint] == sign)
            assert rows.b[row] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("slide", ["influence", "slide_influence"])
def test_an_influence_within_the_stop_is_refused(slide):
    with pytest.raises(FieldError, match=f"{slide}: must exceed the stopping"):
        check_ranges(ing.JointLimitDamperConfig(**{slide: 1e-3}))


def test_joint_limit_rows_skip_the_base(frankie, make_tick):
    q = np.array([5, 5, 5, *frankie.home])
    q[4] = frankie.position_upper[4] - 0.2
    rows = added(
        ing.JointLimitDamper(ing.JointLimitDamperConfig()),
        make_tick(frankie, q),
    ).terms.rows["joint limit"]
    columns = np.abs(rows.A).argmax(axis=1)
    assert (columns >= 2).all()
    assert rows.A[columns == 3].sum() == 1.0


# Collision rows and the active cost


def test_an_obstacle_below_slows_the_way_down(three_link, make_tick):
    # The sphere is 0.6 m from the shoulder and 0.1 m from the elbow; its
    # clearance is half way between stopping and influence.
    tick = make_tick(
        three_link,
        np.zeros(3),
        clearances=one_row(FOREARM, 0.26, (0, 0, -1)),
    )
    config = ing.CollisionDamperConfig(influence=0.5, stopping=0.02, gain=1.0)
    rows = added(ing.CollisionDamper(config), tick).terms.rows["collision"]
    np.testing.assert_allclose(rows.A, [[0.6, 0.1, 0]], atol=1e-15)
    np.testing.assert_allclose(rows.b, [0.5])


def test_the_active_cost_pays_for_getting_away(three_link, make_tick):
    tick = make_tick(
        three_link,
        np.zeros(3),
        clearances=one_row(FOREARM, 0.26, (0, 0, -1)),
    )
    damper = ing.CollisionDamperConfig(influence=0.5, stopping=0.02)
    cost = ing.ActiveCollisionCost(
        ing.ActiveCollisionCostConfig(gain=2.0), damper
    )
    # One row: its weight cancels, and the gain is 2 * 0.5^2.
    np.testing.assert_allclose(
        linear_cost(added(cost, tick)), [0.3, 0.05, 0], atol=1e-15
    )


def test_near_obstacles_weigh_more(three_link, make_tick):
    up, down = (0, 0, 1), (0, 0, -1)
    near, far = one_row(FOREARM, 0.14, down), one_row(FOREARM, 0.38, up)
    clearances = Clearances(
        *(
            np.concatenate([getattr(near, name), getattr(far, name)])
            for name in ("sphere", "distance", "direction_W", "p_WC")
        )
    )
    tick = make_tick(three_link, np.zeros(3), clearances=clearances)
    damper = ing.CollisionDamperConfig(influence=0.5, stopping=0.02)
    cost = ing.ActiveCollisionCost(
        ing.ActiveCollisionCostConfig(gain=1.0), damper
    )
    # Weights 3/4 and 1/4; d_min is the near one.
    expected = 0.75**2 * (0.75 - 0.25) * np.array([0.6, 0.1, 0])
    np.testing.assert_allclose(
        linear_cost(added(cost, tick)), expected, atol=1e-15
    )


def test_nothing_near_adds_nothing(three_link, make_tick):
    tick = make_tick(three_link, np.zeros(3))
    damper = ing.CollisionDamperConfig()
    for ingredient in (
        ing.CollisionDamper(damper),
        ing.ActiveCollisionCost(ing.ActiveCollisionCostConfig(), damper),
    ):
        program = added(ingredient, tick)
        assert not program.terms.rows
        assert not program.terms.linear


@pytest.mark.parametrize("family", ["table", "bookshelf"])
def test_collision_rows_are_the_rates_of_the_clearances(
    frankie, make_tick, family
):
    scene = generate(family, 3)
    field = SignedDistanceField(scene, rows="per_primitive")
    rng = np.random.default_rng(5)
    for _ in range(5):
        q, u = random_state(frankie, rng)

        def distances(q):
            return field.clearances(frankie.spheres_at(q)).distance

        clearances = field.clearances(frankie.spheres_at(q))
        tick = make_tick(frankie, q, clearances=clearances)
        rates = -rate_along(frankie, distances, q, u)
        # Inside a solid the nearest face may change within the step.
        outside = clearances.p_WC - tick.state.spheres.p_WS[clearances.sphere]
        outside = (outside * clearances.direction_W).sum(axis=1) > 1e-3
        assert outside.sum() > 100
        np.testing.assert_allclose(
            (tick.approach_rates @ u)[outside], rates[outside], atol=1e-6
        )


def test_the_active_cost_is_the_mean_rate_of_the_clearances(frankie, make_tick):
    field = SignedDistanceField(generate("table", 3))
    damper = ing.CollisionDamperConfig()
    cost = ing.ActiveCollisionCost(
        ing.ActiveCollisionCostConfig(gain=0.6), damper
    )
    rng = np.random.default_rng(6)
    for _ in range(5):
        q, u = random_state(frankie, rng)
        q[0] += 0.5
        clearances = field.clearances(frankie.spheres_at(q), damper.influence)
        w = damper.influence - clearances.distance

        def weighted(q, w=w, sphere=clearances.sphere):
            d = field.clearances(frankie.spheres_at(q))
            return w @ d.per_sphere(len(frankie.spheres))[sphere] / w.sum()

        nearness = (damper.influence - clearances.minimum()) / (
            damper.influence - damper.stopping
        )
        tick = make_tick(frankie, q, clearances=clearances)
        assert linear_cost(added(cost, tick)) @ u == pytest.approx(
            -0.6 * nearness**2 * rate_along(frankie, weighted, q, u), abs=1e-5
        )


# Manipulability


def test_manipulability_gradient_is_the_measures(frankie):
    def measure(q):
        return manipulability_at(frankie, q)[0]

    rng = np.random.default_rng(7)
    for _ in range(5):
        q, _ = random_state(frankie, rng)
        gradient = manipulability_at(frankie, q)[1]
        numeric = [
            rate_along(frankie, measure, q, u) for u in np.eye(frankie.n_u)[2:]
        ]
        np.testing.assert_allclose(gradient, numeric, atol=1e-7)
        J = arm_jacobian(frankie, q)
        assert measure(q) == pytest.approx(math.sqrt(np.linalg.det(J @ J.T)))


def arm_jacobian(robot, q) -> np.ndarray:
    state = robot.state(q)
    return np.vstack([state.Jw_WE, state.Jv_WE])[:, robot.n_base :]


def manipulability_at(robot, q):
    J = arm_jacobian(robot, q)
    return manipulability(J[:3].copy(), J[3:].copy())


def test_the_cost_rewards_manipulability_with_the_arm_alone(frankie, make_tick):
    q = np.array([0, 0, 0, *frankie.home])
    cost = ing.ManipulabilityCost(ing.ManipulabilityCostConfig(gain=0.3))
    c = linear_cost(added(cost, make_tick(frankie, q)))
    np.testing.assert_array_equal(c[:2], 0)
    np.testing.assert_allclose(c[2:], -0.3 * manipulability_at(frankie, q)[1])


def test_a_singular_arm_has_no_gradient(frankie, three_link):
    # A stretched Panda: all of its joint axes meet the vertical line.
    q = np.zeros(frankie.n_q)
    q[3:] = (0, 0, 0, 0, 0, 0, 0)
    m, gradient = manipulability_at(frankie, q)
    assert m == pytest.approx(0, abs=1e-6)
    assert np.isfinite(gradient).all()
    m, gradient = manipulability_at(three_link, np.zeros(3))
    assert m == 0
    np.testing.assert_array_equal(gradient, 0)


# Base orientation


def test_the_base_turns_towards_the_end_effector(frankie, make_tick):
    q = np.array([0.3, -0.2, 1.1, *frankie.home])
    p_BE_B = frankie.end_effector_pose(np.array([0, 0, 0, *frankie.home]))[:, 3]
    q[3] = 0.4
    reach = p_BE_B[0] - 0.15  # The arm's mount is 0.15 m before B.
    bearing = math.atan2(reach * math.sin(0.4), 0.15 + reach * math.cos(0.4))
    cost = ing.BaseOrientationCost(ing.BaseOrientationCostConfig(gain=0.5))
    c = linear_cost(added(cost, make_tick(frankie, q)))
    np.testing.assert_allclose(c, [0, -0.5 * bearing] + [0] * 7, atol=1e-12)


def test_an_arm_without_base_has_no_base_orientation(three_link, make_tick):
    cost = ing.BaseOrientationCost(ing.BaseOrientationCostConfig())
    program = added(cost, make_tick(three_link, np.zeros(3)))
    assert not program.terms.linear


def test_a_zero_gain_leaves_a_cost_out(frankie, make_tick):
    q = np.array([0, 0, 0, *frankie.home])
    clearances = one_row(0, 0.1, (1, 0, 0))
    tick = make_tick(frankie, q, clearances=clearances)
    for cost in (
        ing.ManipulabilityCost(ing.ManipulabilityCostConfig(gain=0.0)),
        ing.BaseOrientationCost(ing.BaseOrientationCostConfig(gain=0.0)),
        ing.ActiveCollisionCost(
            ing.ActiveCollisionCostConfig(gain=0.0),
            ing.CollisionDamperConfig(),
        ),
    ):
        terms = added(cost, tick).terms
        assert not terms.linear and not terms.quadratic


# Self-collision


def test_self_collision_watches_links_two_joints_apart(three_link):
    pairs = self_collision_pairs(three_link, margin=0.0)
    assert pairs.found.watched == (("upper_arm", "wrist"),)


def test_self_collision_row_is_the_rate_of_the_distance(three_link, make_tick):
    config = ing.SelfCollisionDamperConfig(
        influence=0.5, stopping=0.01, gain=0.7
    )
    pairs = self_collision_pairs(three_link, config.stopping)
    rng = np.random.default_rng(8)
    for _ in range(5):
        q = np.array([0.2, 2.0, 0.1]) + rng.uniform(-0.3, 0.3, 3)
        u = rng.uniform(-1, 1, 3)

        def distance(q):
            return pairs.distances(q).min()

        damper = ing.SelfCollisionDamper(config, three_link)
        rows = added(damper, make_tick(three_link, q)).terms.rows[
            "self-collision"
        ]
        assert rows.A[0] @ u == pytest.approx(
            -rate_along(three_link, distance, q, u), abs=1e-6
        )
        assert rows.b[0] == pytest.approx(0.7 * (distance(q) - 0.01) / 0.49)


def test_each_self_collision_row_is_the_rate_of_its_points(frankie, make_tick):
    """Where the hand faces the base, several pairs of points are near."""
    config = ing.SelfCollisionDamperConfig(influence=0.3)
    pairs = self_collision_pairs(frankie, config.stopping)
    damper = ing.SelfCollisionDamper(config, frankie)
    q = folded_over_the_base(frankie)
    rng = np.random.default_rng(4)
    near = pairs.near(frankie.body_poses(q), config.influence)
    bodies = bodies_of(pairs, near)
    rows = added(damper, make_tick(frankie, q)).terms.rows["self-collision"]
    assert len(rows.b) == len(near) > 10

    def gaps(q):
        """Of points that stay where they are on their links, along n."""
        X_0, X = frankie.body_poses(frankie_q), frankie.body_poses(q)
        moved = []
        for body, p_W in zip(bodies, (near.p_WA, near.p_WB), strict=True):
            X_WX = X[body] @ np.linalg.inv(X_0[body])
            moved.append(np.matvec(X_WX[:, :3, :3], p_W) + X_WX[:, :3, 3])
        return np.vecdot(moved[1] - moved[0], near.normal_W)

    frankie_q = q
    for _ in range(5):
        u = rng.uniform(-1, 1, 9)
        np.testing.assert_allclose(
            rows.A @ u, -rate_along(frankie, gaps, q, u), atol=1e-6
        )
    span = config.influence - config.stopping
    np.testing.assert_allclose(
        rows.b, config.gain * (near.distance - config.stopping) / span
    )


def folded_over_the_base(frankie):
    """A configuration in which the hand is close above the base."""
    q = frankie.q_home.copy()
    q[3:] = (0.0, 0.5, 0.0, -2.9, 0.0, 3.386, 0.785)
    return q


@pytest.mark.parametrize("enabled", [True, False])
def test_a_stretched_or_unwatched_arm_has_no_self_collision_rows(
    three_link, make_tick, enabled
):
    q = [0, 0, 0] if enabled else [0, 2.3, 0]
    config = ing.SelfCollisionDamperConfig(enabled=enabled)
    damper = ing.SelfCollisionDamper(config, three_link)
    assert not added(damper, make_tick(three_link, q)).terms.rows
