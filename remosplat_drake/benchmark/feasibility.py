"""Which generated scenes can be solved at all, decided by their goals.

The generators keep the target point clear of obstacles, but not the gripper
and the arm around it. Here a goal counts as feasible if a search with random
restarts over the base pose and the arm finds a configuration that reaches it
with every sphere clear. A failed search is no proof of the contrary.
"""

import dataclasses as dc
import math

import numpy as np
from scipy.optimize import least_squares

from remosplat_drake.benchmark.scene_generators import generate
from remosplat_drake.controller.servo import pose_error
from remosplat_drake.errors import RemoSplatError
from remosplat_drake.oracle.distance_field import DistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel, load_robot_model
from remosplat_drake.scene.primitive_scene import PrimitiveScene

FILTER_VERSION = 1
"""Raised whenever a scene might be judged differently."""

FLOOR_HEIGHT = 0.03
"""Below it the robot's floor links see nothing; as scenarios do [m]."""

BASE_DISTANCE, BASE_TURN = (0.3, 0.9), 0.8
"""Of guessed bases: from the target, and from facing it [m, rad]."""

ARM_SPREAD = 0.8
"""Standard deviation of guessed arms about the home configuration [rad]."""

MARGIN = 0.5
"""Part of the tolerances that the search aims at."""

CLEARANCE_MARGIN = 5e-4
"""What the search aims at beyond the wanted clearance [m]."""


@dc.dataclass(frozen=True)
class FeasibilityFilter:
    """What a generated scene must allow.

    Attributes:
        spheres: Sphere set of the robot.
        clearance: Of all spheres at the goal [m].
        start_clearance: Of all spheres at the start [m].
        position: Tolerance at the goal [m].
        angle: Tolerance at the goal [rad].
        restarts: How many random first guesses.
        seed: Of the guesses.
    """

    spheres: str = "covering"
    clearance: float = 0.021
    start_clearance: float = 0.05
    position: float = 0.02
    angle: float = math.radians(2.0)
    restarts: int = 30
    seed: int = 0

    @property
    def name(self) -> str:
        """What tables call the filter."""
        return (
            f"goal-feasible v{FILTER_VERSION} ({self.spheres} spheres,"
            f" {1e3 * self.clearance:g} mm)"
        )


def feasible_seeds(
    family: str, count: int, criteria: FeasibilityFilter
) -> list[int]:
    """The first seeds of a family whose scenes pass the filter."""
    robot = load_robot_model("frankie", criteria.spheres, FLOOR_HEIGHT)
    seeds: list[int] = []
    seed = 0
    while len(seeds) < count:
        if passes(robot, generate(family, seed), criteria):
            seeds.append(seed)
        seed += 1
    return seeds


def passes(
    robot: RobotModel, scene: PrimitiveScene, criteria: FeasibilityFilter
) -> bool:
    """Whether the start is clear and the goal is feasible."""
    field = SignedDistanceField(scene)
    start = np.array([*(scene.X_WB_start or (0, 0, 0)), *robot.home])
    clearance = field.clearances(robot.spheres_at(start)).minimum()
    return clearance > criteria.start_clearance and (
        goal_configuration(robot, scene, criteria) is not None
    )


def goal_configuration(
    robot: RobotModel, scene: PrimitiveScene, criteria: FeasibilityFilter
) -> np.ndarray | None:
    """A configuration (n_q,) at the goal, clear of everything, if found.

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
        criteria,
    )
    rng = np.random.default_rng(criteria.seed)
    for _ in range(criteria.restarts):
        q = search.descend(search.guess(rng))
        if search.is_solved(q):
            return q
    return None


@dc.dataclass(frozen=True, eq=False)
class _GoalSearch:
    """Nonlinear least squares over q: pose error, and missing clearance."""

    robot: RobotModel
    field: DistanceField
    X_WT: np.ndarray
    criteria: FeasibilityFilter

    def guess(self, rng: np.random.Generator) -> np.ndarray:
        """A base around the target that faces it, and any arm."""
        robot = self.robot
        bearing = rng.uniform(-np.pi, np.pi)
        away = rng.uniform(*BASE_DISTANCE)
        p = self.X_WT[:2, 3] - away * np.array(
            [np.cos(bearing), np.sin(bearing)]
        )
        yaw = bearing + rng.uniform(-BASE_TURN, BASE_TURN)
        arm = robot.home + rng.normal(0, ARM_SPREAD, len(robot.home))
        lower, upper = self._bounds
        return np.clip(np.array([*p, yaw, *arm]), lower + 1e-6, upper - 1e-6)

    @property
    def _bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return self.robot.position_lower, self.robot.position_upper

    def descend(self, q: np.ndarray) -> np.ndarray:
        """The local optimum below a guess."""
        return least_squares(
            self.residuals,
            q,
            jac=self.jacobian,  # pyright: ignore[reportArgumentType]
            bounds=self._bounds,
            max_nfev=60,
        ).x

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
        """Pose error beyond the tolerance aimed at, and missing clearance.

        Shape (2 + n,), each divided by its tolerance.
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
        """Derivatives of the residuals by q, shape (2 + n, n_q)."""
        state = self.robot.state(q)
        error = pose_error(state.X_WE, self.X_WT)
        n = len(self.robot.spheres)
        J = np.zeros((2 + n, self.robot.n_q))
        along = error.p_ET_W / max(error.distance, 1e-9)
        axis = error.rotation_W / max(error.angle, 1e-9)
        if error.distance > MARGIN * self.criteria.position:
            J[0] = -along @ self._by_q(state.Jv_WE) / self.criteria.position
        if error.angle > MARGIN * self.criteria.angle:
            turning = np.hstack([np.zeros((3, 2)), state.Jw_WE[:, 1:]])
            J[1] = -axis @ turning / self.criteria.angle
        near = self.field.clearances(state.spheres, self._wanted)
        for sphere, n_W in zip(near.sphere, near.direction_W, strict=True):
            # The clearance falls along n, so what is missing grows.
            slope = n_W @ self._by_q(state.Jv_WS[sphere])
            J[2 + sphere] = slope / self.criteria.position
        return J

    @property
    def _wanted(self) -> float:
        return self.criteria.clearance + CLEARANCE_MARGIN

    @staticmethod
    def _excess(ratio: float) -> float:
        return max(ratio - MARGIN, 0.0)

    @staticmethod
    def _by_q(Jv: np.ndarray) -> np.ndarray:
        """From velocities u to configurations: the base may also slip."""
        return np.hstack([np.eye(3)[:, :2], Jv[:, 1:]])
