"""Benchmarks of the self-collision distances of a tick."""

import numpy as np

from remosplat_drake.controller.ingredients import SelfCollisionDamperConfig
from remosplat_drake.robot.robot_description import shipped_robots
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.robot.self_collision.pairs import self_collision_pairs
from remosplat_drake.timing.measuring import Case, in_turn

_POSTURES = 200
"""Number of configurations. Each is half way between the home configuration and
a random configuration."""


def self_collision_cases() -> list[Case]:
    """Makes a benchmark for each shipped robot."""
    return [_case(name) for name in shipped_robots()]


def _case(name: str) -> Case:
    robot, config = load_robot(name), SelfCollisionDamperConfig()
    pairs = self_collision_pairs(robot, config.stopping)
    rng = np.random.default_rng(0)
    arm = slice(robot.n_q - len(robot.home), None)
    lower = np.maximum(robot.position_lower[arm], -np.pi)
    upper = np.minimum(robot.position_upper[arm], np.pi)
    poses = []
    for drawn in rng.uniform(lower, upper, (_POSTURES, len(robot.home))):
        q = robot.q_home
        q[arm] += 0.5 * (drawn - q[arm])
        poses.append(robot.body_poses(q))
    return Case(
        f"self-collision: {name}, {len(pairs)} pairs of shapes",
        in_turn(poses, lambda X_WL: pairs.near(X_WL, config.influence)),
    )
