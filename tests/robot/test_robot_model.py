"""Poses and Jacobians against the plant, and against finite differences."""

import dataclasses as dc
import shutil
from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from remosplat_drake.base.errors import FieldError, FileError, RemoSplatError
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_description import load_robot_description
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.robot.sphere_model import SphereModel

THREE_LINK = Path(__file__).resolve().parents[1] / "data" / "three_link.yaml"
EXACT = 1e-12
STEP = 1e-6


class Referee:
    """The same robot in a MultibodyPlant, posed by the same q."""

    def __init__(self, robot: RobotModel):
        self.robot = robot
        self.plant = MultibodyPlant(time_step=0.0)
        add_robot_model(robot.description, self.plant)
        for name, position in robot.description.locked.items():
            self.plant.GetJointByName(name).set_default_positions([position])
        self.plant.Finalize()
        self.context = self.plant.CreateDefaultContext()
        joints = [self.plant.GetJointByName(n) for n in robot.joint_names]
        self._q = [joint.position_start() for joint in joints]
        self._v = [joint.velocity_start() for joint in joints]

    def pose_at(self, q: np.ndarray) -> None:
        positions = self.plant.GetPositions(self.context)
        positions[self._q] = q
        self.plant.SetPositions(self.context, positions)

    def X_W(self, frame) -> np.ndarray:
        return frame.CalcPoseInWorld(self.context).GetAsMatrix4()

    def jacobians(self, frame, p_FP, N) -> tuple[np.ndarray, np.ndarray]:
        """(Jw, Jv) of a point fixed in a frame, with respect to u."""
        world = self.plant.world_frame()
        J = self.plant.CalcJacobianSpatialVelocity(
            self.context, JacobianWrtVariable.kV, frame, p_FP, world, world
        )[:, self._v]
        return J[:3] @ N, J[3:] @ N


def random_configurations(robot: RobotModel, n: int) -> np.ndarray:
    """Inside the joint limits, with the base anywhere within 3 m."""
    rng = np.random.default_rng(0)
    lower = np.where(
        np.isfinite(robot.position_lower), robot.position_lower, -3
    )
    upper = np.where(np.isfinite(robot.position_upper), robot.position_upper, 3)
    return rng.uniform(lower, upper, (n, robot.n_q))


def test_poses_equal_the_plants(robot):
    referee = Referee(robot)
    frames = robot.description.effector_frames.values()
    frames_E = [referee.plant.GetFrameByName(name) for name in frames]
    for q in random_configurations(robot, 20):
        referee.pose_at(q)
        state = robot.state(q)
        X_WEs = [referee.X_W(frame) for frame in frames_E]
        np.testing.assert_allclose(state.X_WEs, X_WEs, atol=EXACT)
        np.testing.assert_array_equal(state.X_WE, robot.end_effector_pose(q))
        for i, link in enumerate(robot.spheres.links):
            body = referee.plant.GetBodyByName(link)
            X_WL = referee.X_W(body.body_frame())
            p_WS = X_WL[:3, :3] @ robot.spheres.p_LS[i] + X_WL[:3, 3]
            np.testing.assert_allclose(state.spheres.p_WS[i], p_WS, atol=EXACT)
            np.testing.assert_allclose(
                state.spheres.R_WL[i], X_WL[:3, :3], atol=EXACT
            )


def test_base_pose_equals_the_plants(robot):
    referee = Referee(robot)
    base = robot.description.base
    for q in random_configurations(robot, 5):
        referee.pose_at(q)
        X_WB = np.eye(4)
        if base:
            body = referee.plant.GetBodyByName(base.body)
            X_WB = referee.X_W(body.body_frame())
        np.testing.assert_allclose(robot.state(q).X_WB, X_WB, atol=EXACT)


def test_jacobians_equal_the_plants(robot):
    referee = Referee(robot)
    frames = robot.description.effector_frames.values()
    frames_E = [referee.plant.GetFrameByName(name) for name in frames]
    for q in random_configurations(robot, 20):
        referee.pose_at(q)
        state = robot.state(q)
        N = robot.velocity_map(q)
        for effector, frame in enumerate(frames_E):
            J_WE = np.vstack(referee.jacobians(frame, np.zeros(3), N))
            np.testing.assert_allclose(state.J_WE(effector), J_WE, atol=EXACT)
        for i, link in enumerate(robot.spheres.links):
            frame_L = referee.plant.GetBodyByName(link).body_frame()
            _, Jv_WS = referee.jacobians(frame_L, robot.spheres.p_LS[i], N)
            np.testing.assert_allclose(state.Jv_WS[i], Jv_WS, atol=EXACT)


def test_jacobians_equal_finite_differences(robot):
    for q in random_configurations(robot, 5):
        state = robot.state(q)
        for j in range(robot.n_u):
            ahead, behind = (
                robot.state(robot.advance(q, np.eye(robot.n_u)[j], dt))
                for dt in (STEP, -STEP)
            )
            Jv_WS = (ahead.spheres.p_WS - behind.spheres.p_WS) / (2 * STEP)
            np.testing.assert_allclose(state.Jv_WS[:, :, j], Jv_WS, atol=1e-8)
            X_dot = (ahead.X_WE - behind.X_WE) / (2 * STEP)
            np.testing.assert_allclose(
                state.Jv_WE[:, j], X_dot[:3, 3], atol=1e-8
            )
            W = X_dot[:3, :3] @ state.X_WE[:3, :3].T  # [w]x, skew-symmetric.
            np.testing.assert_allclose(
                state.Jw_WE[:, j], [W[2, 1], W[0, 2], W[1, 0]], atol=1e-8
            )


def test_velocity_map_is_the_rate_of_advance(robot):
    rng = np.random.default_rng(1)
    for q in random_configurations(robot, 10):
        u = rng.uniform(-1, 1, robot.n_u)
        q_dot = (robot.advance(q, u, STEP) - robot.advance(q, u, -STEP)) / (
            2 * STEP
        )
        np.testing.assert_allclose(robot.velocity_map(q) @ u, q_dot, atol=1e-8)


def test_advance_composes(robot):
    """Holding u for 0.3 s is holding it for 0.1 s and then for 0.2 s."""
    rng = np.random.default_rng(2)
    for q in random_configurations(robot, 10):
        u = rng.uniform(-2, 2, robot.n_u)
        q_between = robot.advance(q, u, 0.1)
        np.testing.assert_allclose(
            robot.advance(q_between, u, 0.2),
            robot.advance(q, u, 0.3),
            atol=EXACT,
        )


@pytest.mark.parametrize("count", [1, 7])
def test_several_times_at_once_are_each_on_its_own(robot, count):
    rng = np.random.default_rng(3)
    q = random_configurations(robot, 1)[0]
    u, times = rng.uniform(-2, 2, robot.n_u), rng.uniform(0, 1, count)
    np.testing.assert_allclose(
        robot.advance_for(q, u, times),
        [robot.advance(q, u, time) for time in times],
        atol=EXACT,
    )


def test_some_spheres_at_some_configurations_are_where_they_belong(robot):
    states = random_configurations(robot, 4)
    state = np.array([0, 0, 2, 1, 1, 1, 3, 0])
    sphere = np.arange(len(state)) % len(robot.spheres)
    placed = [robot.spheres_at(q) for q in states]
    found = robot.place_spheres(states, state, sphere)
    for field in dc.fields(found):
        np.testing.assert_allclose(
            getattr(found, field.name),
            [
                getattr(placed[k], field.name)[i]
                for k, i in zip(state, sphere, strict=True)
            ],
            atol=EXACT,
        )


def test_advance_leaves_its_arguments_alone(robot):
    q = random_configurations(robot, 1)[0]
    u = np.ones(robot.n_u)
    before = q.copy()
    robot.advance(q, u, 0.1)
    np.testing.assert_array_equal(q, before)
    np.testing.assert_array_equal(u, np.ones(robot.n_u))


def test_quarter_circle_of_the_base():
    """At pi/2 m/s and pi/2 rad/s for 1 s, on a circle of radius 1 m."""
    robot = load_robot("frankie")
    u = np.zeros(9)
    u[:2] = np.pi / 2
    q = robot.advance(np.zeros(10), u, 1.0)
    np.testing.assert_allclose(q[:3], [1, 1, np.pi / 2], atol=EXACT)


def test_an_omnidirectional_base_goes_round_a_place_that_it_faces():
    """At pi/2 m/s to the left and pi/2 rad/s for 1 s: a circle of 1 m."""
    robot = load_robot("ridgeback_panda")
    u = np.zeros(10)
    u[1], u[2] = -np.pi / 2, np.pi / 2
    q = robot.advance(np.zeros(10), u, 1.0)
    np.testing.assert_allclose(q[:3], [1, -1, np.pi / 2], atol=EXACT)


def test_bounds_on_jacobians_and_their_change_hold(robot):
    """At random configurations and commands, by differences."""
    rng = np.random.default_rng(4)
    for q in random_configurations(robot, 20):
        state = robot.state(q)
        size = np.linalg.norm(state.Jv_WS, axis=1)
        assert (size <= robot.jacobian_bound + 1e-9).all()
        u = rng.uniform(-1, 1, robot.n_u)
        ahead = robot.state(robot.advance(q, u, STEP)).Jv_WS @ u
        change = np.linalg.norm(ahead - state.Jv_WS @ u, axis=1) / STEP
        bound = np.abs(u) @ robot.hessian_bound @ np.abs(u)
        assert (change <= bound + 1e-4).all()


def test_straight_line_of_the_base():
    robot = load_robot("frankie")
    u = np.zeros(9)
    u[0] = 0.5
    q0 = np.zeros(10)
    q0[2] = np.pi / 6
    q = robot.advance(q0, u, 2.0)
    np.testing.assert_allclose(
        q[:3], [np.cos(np.pi / 6), 0.5, np.pi / 6], atol=EXACT
    )


def test_three_link_arm_by_hand():
    """Arm stretched along x at height 1: the tip is past the tilted roll."""
    robot = load_robot(THREE_LINK)
    c, s = np.cos(0.3), np.sin(0.3)
    X_WE = robot.end_effector_pose(np.zeros(3))
    np.testing.assert_allclose(
        X_WE[:3, 3], [0.9 + 0.1 * c, 0.02, 1 - 0.1 * s], atol=EXACT
    )
    state = robot.state(np.zeros(3))
    # The shoulder turns about y through (0, 0, 1): v = y x r = (z, 0, -x).
    np.testing.assert_allclose(
        state.Jv_WE[:, 0], [-0.1 * s, 0, -(0.9 + 0.1 * c)], atol=EXACT
    )
    np.testing.assert_allclose(state.Jw_WE[:, 2], [c, 0, -s], atol=EXACT)


def test_sizes(robot):
    base = robot.description.base
    n_base = {None: 0, "differential": 2, "omnidirectional": 3}[
        base and base.drive
    ]
    assert robot.n_base == n_base
    assert robot.n_u == n_base + len(robot.home)
    assert robot.n_q == (3 if base else 0) + len(robot.home)
    assert robot.velocity_limit.shape == (robot.n_u,)
    assert robot.position_lower.shape == (robot.n_q,)
    assert (robot.position_lower < robot.position_upper).all()


def test_floor_links_ignore_the_floor():
    robot = load_robot("frankie", floor_height=0.03)
    on_base = robot.spheres.on_links({"base_link"})
    spheres = robot.spheres_at(np.r_[0, 0, 0, robot.home])
    assert (spheres.ignore_below[on_base] == 0.03).all()
    assert np.isneginf(spheres.ignore_below[~on_base]).all()


def test_unknown_robot_names_the_known_ones():
    with pytest.raises(FileError, match="did you mean 'frankie'"):
        load_robot("franky")


def test_unknown_sphere_set_names_the_known_ones():
    with pytest.raises(FieldError, match="covering, paper"):
        load_robot("frankie", spheres="coarse")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"velocity_limits": [1.0]}, "velocity_limits: expected 3 numbers"),
        ({"acceleration_limits": []}, "acceleration_limits: expected 3"),
        ({"home": [0.0, 0.0]}, "home: expected one number"),
        ({"end_effector_frame": "tcp"}, "unknown frame 'tcp'.*; valid: "),
        ({"end_effector_frame": ""}, "end_effector_frame: is missing; name"),
        ({"locked": {"wheel": 0.0}}, "no joint 'wheel'"),
    ],
)
def test_bad_descriptions_name_the_field(change, message):
    description = dc.replace(load_robot_description(THREE_LINK), **change)
    with pytest.raises(RemoSplatError, match=message):
        RobotModel(description, load_robot(THREE_LINK).spheres)


def test_spheres_on_an_unknown_link_name_the_links():
    spheres = SphereModel("x", ("wing",), np.zeros((1, 3)), np.ones(1))
    with pytest.raises(RemoSplatError, match=r"'wing'.*upper_arm"):
        RobotModel(load_robot_description(THREE_LINK), spheres)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("0.25 0 0", "1_000 0 0", r"three_link\.urdf: Expected 3 values"),
        ('velocity="2"', 'velocity="-2"', r"urdf: Drake refuses it in set_vel"),
        (
            'lower="-2" upper="2"',
            'lower="2" upper="2"',
            r"arm.joints\[0\]: shoulder has no",
        ),
    ],
)
def test_a_bad_model_is_named(tmp_path, old, new, problem):
    for path in THREE_LINK.parent.glob("three_link*"):
        shutil.copy(path, tmp_path)
    model = tmp_path / "three_link.urdf"
    assert old in model.read_text()
    model.write_text(model.read_text().replace(old, new))
    with pytest.raises(RemoSplatError, match=problem):
        load_robot(tmp_path / THREE_LINK.name)


def test_rounding_beyond_a_limit_is_on_it(three_link):
    q = three_link.position_upper.copy()
    q[0] += 4e-4  # As 3.142 is beyond pi.
    assert "beyond its limits" in three_link.beyond_limits(q)
    rounded = three_link.rounded_into_limits(q)
    np.testing.assert_array_equal(rounded, three_link.position_upper)
    assert not three_link.beyond_limits(rounded)
    # More than that is no rounding, and stays for an error.
    q[0] += 1e-2
    np.testing.assert_array_equal(three_link.rounded_into_limits(q), q)


def test_a_configuration_of_another_length_is_refused(frankie):
    """Kernels would read what lies behind it in memory."""
    for ask in (frankie.body_poses, frankie.spheres_at, frankie.state):
        with pytest.raises(ValueError, match=r"shape \(10,\), not \(7,\)"):
            ask(frankie.home)
