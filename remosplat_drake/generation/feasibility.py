"""Determines which generated scenes have feasible goals.

The generators keep the target point clear of obstacles, but not the gripper and
the arm around it. A goal counts as feasible if a search over base pose and arm
joints, with random restarts, finds a configuration that reaches it and keeps
the clearance of every sphere. A failed search does not prove that the goal is
infeasible.
"""

import dataclasses as dc
import math
from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.distance_field import DistanceField

FILTER_VERSION = 1
"""Version of the filter. Increase it whenever the filter's decisions may
change."""

BASE_DISTANCE = (0.6, 1.0)
"""Initial positions of the base are at a distance from the target in this range
[m]."""

BEARING_SPREAD, BASE_TURN = 0.6, 0.8
"""Initial positions of the base are spread around the direction from the target
to the start, with this standard deviation (first number). At such a position,
the angle between the base's heading and the direction to the target is at most
this (second number) [rad]."""

ARM_SPREAD = 0.8
"""Initial positions of the arm's joints are spread around the home
configuration with this standard deviation [rad]."""

ARM_LENGTH = 0.3
"""To compare angles with distances, inverse kinematics of the arm's initial
posture multiplies angles by this length [m]."""

MARGIN = 0.5
"""Fraction of the tolerances that the search tries to reach."""

CLEARANCE_MARGIN = 5e-4
"""The search tries to exceed the required clearance by this length [m]."""


@dc.dataclass(frozen=True)
class FeasibilityFilter:
    """Criteria that a generated scene must meet.

    Attributes:
        spheres: Name of the robot's sphere set.
        clearance: Least clearance that all spheres must keep at the goal [m].
        start_clearance: Least clearance that all spheres must keep at the start
            [m].
        position: Position tolerance at the goal [m].
        angle: Angle tolerance at the goal [rad].
        restarts: Number of random initial guesses.
        seed: Seed of the random guesses.
    """

    spheres: str = "covering"
    clearance: float = 0.021
    start_clearance: float = 0.05
    position: float = 0.02
    angle: float = math.radians(2.0)
    restarts: int = 60
    seed: int = 0

    @property
    def name(self) -> str:
        """Name of the filter in tables."""
        return (
            f"goal-feasible v{FILTER_VERSION} ({self.spheres} spheres,"
            f" {1e3 * self.clearance:g} mm)"
        )


def passes(
    robot: RobotModel, scene: PrimitiveScene, criteria: FeasibilityFilter
) -> bool:
    """Returns whether a scene meets the criteria at the start and goal."""
    field = SignedDistanceField(scene)
    start = np.array([*(scene.X_WB_start or (0, 0, 0)), *robot.home])
    clearance = field.clearances(robot.spheres_at(start)).minimum()
    return (
        clearance > criteria.start_clearance
        and hand_fits(robot, scene, criteria)
        and goal_configuration(robot, scene, criteria) is not None
    )


def hand_fits(
    robot: RobotModel, scene: PrimitiveScene, criteria: FeasibilityFilter
) -> bool:
    """Returns whether the end effector's spheres are clear at the goal.

    The test is quick, and a negative result proves that the goal is infeasible.
    It is evaluated at the exact goal. A configuration within the tolerances of
    the goal displaces a sphere by at most the position tolerance plus the angle
    tolerance times the sphere's distance from the end effector. This sum is
    added to the sphere's clearance.
    """
    assert scene.X_WE_target is not None
    fixed = robot.leading_spheres
    X_WE = robot.end_effector_pose(np.zeros(robot.n_q))
    spheres = robot.spheres_at(np.zeros(robot.n_q)).select(fixed)
    p_ES = (spheres.p_WS - X_WE[:3, 3]) @ X_WE[:3, :3]
    R_WT = scene.X_WE_target.rotation().matrix()
    p_WS = p_ES @ R_WT.T + scene.X_WE_target.translation()
    answer = SignedDistanceField(scene).clearances(
        Spheres.at(p_WS, spheres.radius)
    )
    gain = criteria.position + criteria.angle * np.linalg.norm(p_ES, axis=1)
    best = answer.per_sphere(len(p_WS)) + gain
    return bool((best >= criteria.clearance).all())


def goal_configuration(
    robot: RobotModel,
    scene: PrimitiveScene,
    criteria: FeasibilityFilter,
    margin: float = MARGIN,
) -> np.ndarray | None:
    """Searches for a collision-free configuration at the goal.

    Args:
        robot: Model of a robot with a mobile base.
        scene: Scene with a target.
        criteria: Clearances, tolerances and extent of the search.
        margin: Fraction of the tolerances that the search tries to reach.

    Returns:
        The configuration, shape (n_q,); None if none is found.

    Raises:
        RemoSplatError: The scene has no target, or the robot no base.
    """
    if scene.X_WE_target is None or not robot.n_base:
        raise RemoSplatError(
            f"{scene.name}: needs a target, and a robot with a mobile base"
        )
    search = _GoalSearch(
        robot,
        SignedDistanceField(scene),
        scene.X_WE_target.GetAsMatrix4(),
        _bearing(scene),
        criteria,
        margin,
    )
    rng = np.random.default_rng(criteria.seed)
    for _ in range(criteria.restarts):
        q = search.descend(search.guess(rng))
        if search.is_solved(q):
            return q
    return None


def _bearing(scene: PrimitiveScene) -> float:
    """Returns the direction from the start to the target in W [rad]."""
    assert scene.X_WE_target is not None
    x, y, _ = scene.X_WB_start or (0.0, 0.0, 0.0)
    p_WT = scene.X_WE_target.translation()
    return math.atan2(p_WT[1] - y, p_WT[0] - x)


def _descend(
    residuals: Callable[[np.ndarray], np.ndarray],
    jacobian: Callable[[np.ndarray], np.ndarray],
    x: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:
    return least_squares(
        residuals,
        x,
        jac=jacobian,  # pyright: ignore[reportArgumentType]
        bounds=bounds,
        max_nfev=60,
    ).x


@dc.dataclass(frozen=True, eq=False)
class _GoalSearch:
    """Nonlinear least squares over q of pose error and missing clearance."""

    robot: RobotModel
    field: DistanceField
    X_WT: np.ndarray
    bearing: float
    criteria: FeasibilityFilter
    margin: float = MARGIN

    def guess(self, rng: np.random.Generator) -> np.ndarray:
        """Draws a base pose on the start's side of the target, and an arm.

        The arm's posture is found by inverse kinematics, with the base fixed
        and without obstacles.
        """
        robot = self.robot
        lower, upper = robot.position_lower, robot.position_upper
        bearing = self.bearing + rng.normal(0, BEARING_SPREAD)
        away = rng.uniform(*BASE_DISTANCE)
        x, y = self.X_WT[:2, 3] - away * np.array(
            [np.cos(bearing), np.sin(bearing)]
        )
        base = np.array([x, y, bearing + rng.uniform(-BASE_TURN, BASE_TURN)])
        arm = robot.home + rng.normal(0, ARM_SPREAD, len(robot.home))
        arm = np.clip(arm, lower[3:] + 1e-6, upper[3:] - 1e-6)

        def reaching(arm: np.ndarray) -> np.ndarray:
            X_WE = robot.end_effector_pose(np.array([*base, *arm]))
            error = pose_error(X_WE, self.X_WT)
            return np.array([*error.p_ET_W, *(ARM_LENGTH * error.rotation_W)])

        def slope(arm: np.ndarray) -> np.ndarray:
            state = robot.state(np.array([*base, *arm]))
            J = np.vstack([state.Jv_WE, ARM_LENGTH * state.Jw_WE])
            return -J[:, robot.n_base :]

        arm = _descend(reaching, slope, arm, (lower[3:], upper[3:]))
        return np.array([*base, *arm])

    def descend(self, q: np.ndarray) -> np.ndarray:
        """Returns the local optimum that the descent from a guess reaches."""
        bounds = self.robot.position_lower, self.robot.position_upper
        return _descend(self.residuals, self.jacobian, q, bounds)

    def is_solved(self, q: np.ndarray) -> bool:
        """Whether q meets the criteria."""
        error = pose_error(self.robot.end_effector_pose(q), self.X_WT)
        clearance = self.field.clearances(self.robot.spheres_at(q)).minimum()
        return (
            error.distance < self.criteria.position
            and error.angle < self.criteria.angle
            and clearance >= self.criteria.clearance
        )

    def residuals(self, q: np.ndarray) -> np.ndarray:
        """Returns the excesses of the pose error, and the missing clearances.

        Each entry is divided by its tolerance; the shape is (2 + n,).
        """
        error = pose_error(self.robot.end_effector_pose(q), self.X_WT)
        n = len(self.robot.spheres)
        distance = self.field.clearances(self.robot.spheres_at(q)).per_sphere(n)
        return np.concatenate(
            [
                [
                    self._excess(error.distance / self.criteria.position),
                    self._excess(error.angle / self.criteria.angle),
                ],
                np.maximum(self._wanted - distance, 0) / self.criteria.position,
            ]
        )

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Returns the derivatives of the residuals by q, shape (2 + n, n_q)."""
        state = self.robot.state(q)
        error = pose_error(state.X_WE, self.X_WT)
        n = len(self.robot.spheres)
        J = np.zeros((2 + n, self.robot.n_q))
        along = error.p_ET_W / max(error.distance, 1e-9)
        axis = error.rotation_W / max(error.angle, 1e-9)
        if error.distance > self.margin * self.criteria.position:
            J[0] = -along @ self._by_q(state.Jv_WE) / self.criteria.position
        if error.angle > self.margin * self.criteria.angle:
            turning = np.hstack([np.zeros((3, 2)), self._from_yaw(state.Jw_WE)])
            J[1] = -axis @ turning / self.criteria.angle
        near = self.field.clearances(state.spheres, self._wanted)
        for sphere, n_W in zip(near.sphere, near.direction_W, strict=True):
            # The clearance decreases along n, so the missing clearance
            # increases along n.
            slope = n_W @ self._by_q(state.Jv_WS[sphere])
            J[2 + sphere] = slope / self.criteria.position
        return J

    @property
    def _wanted(self) -> float:
        return self.criteria.clearance + CLEARANCE_MARGIN

    def _excess(self, ratio: float) -> float:
        return max(ratio - self.margin, 0.0)

    def _by_q(self, Jv: np.ndarray) -> np.ndarray:
        """Maps a Jacobian in u to one in q, with sideways base motion."""
        return np.hstack([np.eye(3)[:, :2], self._from_yaw(Jv)])

    def _from_yaw(self, J: np.ndarray) -> np.ndarray:
        """The columns of a Jacobian for the yaw rate and the arm."""
        return J[:, self.robot.n_base - 1 :]
