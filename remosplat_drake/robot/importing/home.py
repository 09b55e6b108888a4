"""Guesses a home configuration: manipulable and far from self-collision."""

from itertools import combinations, groupby

import numpy as np
from scipy.spatial.distance import cdist

from remosplat_drake.robot.importing.mirror import find_mirror
from remosplat_drake.robot.robot_model import RobotModel

SAMPLES = 2000
"""Number of random configurations."""

_CLOSER_LOOKS = 500
"""Distances between links are computed for this many of the best
configurations."""

_CLEAR = 0.03
"""The score does not increase with the distance between two links above this
[m]."""

_WITHIN = 0.15
"""Joints keep at least this distance from both limits, as a fraction of the
range."""

_TWISTED = 0.05
"""A joint at half a turn from zero reduces the score by this amount, in units
of manipulability."""


def guess_home(robot: RobotModel, seed: int = 0) -> np.ndarray:
    """Draws arm configurations, and returns the best one as home.

    The score of a configuration is the manipulability of the arms (Yoshikawa
    1985). The score is higher if the hands are in front of the robot and the
    joints are near zero. It is lower if links extend below the height of the
    arm's first joint. For the configurations with the best scores, the
    distances between links that are two or more joints apart are added to the
    score.

    Args:
        robot: The robot; a mobile base does not move.
        seed: Seed of the random configurations.

    Returns:
        The arm's configuration, shape (n_arm,) [rad, m].
    """
    rng = np.random.default_rng(seed)
    arm = slice(robot.n_q - len(robot.home), robot.n_q)
    lower, upper = robot.position_lower[arm], robot.position_upper[arm]
    margin = _WITHIN * (upper - lower)
    lower, upper = lower + margin, upper - margin
    # Joints stay within half a turn of zero.
    wide = robot.arm_turns & (upper - lower > 2 * np.pi)
    lower, upper = np.where(wide, -np.pi, lower), np.where(wide, np.pi, upper)
    draws = rng.uniform(lower, upper, (SAMPLES, len(lower)))
    mirror = find_mirror(robot)
    if mirror is not None:
        images = np.array([mirror.symmetric(q) for q in draws])
        inside = ((images >= lower) & (images <= upper)).all(axis=1)
        draws = images[inside] if inside.any() else draws
    pairs, foot = _watched(robot), _foot(robot)
    scores = np.array([_ability(robot, q, foot) for q in draws])
    best = np.argsort(-scores)[:_CLOSER_LOOKS]
    scores = [scores[i] + _clearness(robot, draws[i], pairs) for i in best]
    return draws[best[int(np.argmax(scores))]].round(3)


def tightness(robot: RobotModel, q_arm: np.ndarray) -> float:
    """Returns the sum of the links' overlaps at a configuration [m].

    Args:
        robot: The robot.
        q_arm: The arm's configuration, shape (n_arm,) [rad, m].
    """
    q = np.concatenate([np.zeros(robot.n_q - len(q_arm)), q_arm])
    gaps = _gaps(robot, q, _watched(robot))
    return float(-np.minimum(gaps, 0.0).sum())


def keeps_off_itself(robot: RobotModel, q: np.ndarray, room: float) -> bool:
    """Returns whether links that are apart at home are also apart at q.

    Links that are close to each other at home, such as those of a short wrist,
    may be up to 3 cm closer at q.

    Args:
        robot: The robot.
        q: Configuration, shape (n_q,) [rad, m].
        room: The required distance [m].
    """
    pairs = _watched(robot)
    at_home = _gaps(robot, robot.q_home, pairs)
    least = np.where(at_home < room, at_home - _CLEAR, room)
    return bool((_gaps(robot, q, pairs) >= least).all())


def _ability(robot: RobotModel, q_arm: np.ndarray, foot: float) -> float:
    """Returns a score of the hands' manipulability and position."""
    q = np.concatenate([np.zeros(robot.n_q - len(q_arm)), q_arm])
    state = robot.state(q)
    turns = robot.arm_turns
    low = np.minimum(state.spheres.p_WS[:, 2] - state.spheres.radius, foot)
    below = foot - low[robot.moved_by_arm].min(initial=foot)
    score = -10.0 * below - _TWISTED * abs(q_arm[turns] / np.pi).mean()
    for i, X_WE in enumerate(state.X_WEs):
        J = state.J_WE(i)[:, robot.n_base :]
        J = J[:, turns] if turns.any() else J
        J = J[:, np.abs(J).any(axis=0)]
        singular = np.linalg.svd(J, compute_uv=False)
        able = float(np.prod(singular)) ** (1 / max(len(singular), 1))
        x, y, z = X_WE[:3, 3] - state.X_WB[:3, 3]
        ahead = x / max(np.linalg.norm([x, y, z]), 1e-9)
        # With several hands, each belongs to one side.
        aside = abs(np.arctan2(y, x)) if len(state.X_WEs) == 1 else 0.0
        score += (able + 0.1 * (ahead - aside)) / len(state.X_WEs)
    return score


def _clearness(
    robot: RobotModel,
    q_arm: np.ndarray,
    pairs: np.ndarray,
) -> float:
    """Returns the sum of the links' distances, each at most `_CLEAR` [m]."""
    q = np.concatenate([np.zeros(robot.n_q - len(q_arm)), q_arm])
    return 10.0 * float(np.minimum(_gaps(robot, q, pairs), _CLEAR).sum())


def _watched(robot: RobotModel) -> np.ndarray:
    """Pairs of links that are two moving joints apart, shape (n, 2).

    A link is given by its place among the links that have spheres.
    """
    tree = robot.tree
    links = [link for link, _ in groupby(robot.spheres.links)]
    pairs = []
    for (i, a), (j, b) in combinations(enumerate(links), 2):
        between = set(tree.chain(tree.index(a))) ^ set(
            tree.chain(tree.index(b))
        )
        if sum(tree.position[body] >= 0 for body in between) >= 2:
            pairs.append((i, j))
    return np.array(pairs, int).reshape(-1, 2)


def _gaps(robot: RobotModel, q: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Returns the least distance between spheres of each pair of links [m]."""
    spheres = robot.spheres_at(q)
    p, r = spheres.p_WS, spheres.radius
    distance = cdist(p, p) - r[:, None] - r
    count = [len(list(own)) for _, own in groupby(robot.spheres.links)]
    first = np.cumsum([0, *count[:-1]])
    for axis in range(2):
        distance = np.minimum.reduceat(distance, first, axis=axis)
    return distance[tuple(pairs.T)]


def _foot(robot: RobotModel) -> float:
    """Height of the arm's first joint; no link should be far below it."""
    tree = robot.tree
    first = int(np.flatnonzero(tree.position == robot.n_q - len(robot.home))[0])
    X_WL = robot.body_poses(np.zeros(robot.n_q))
    return float((X_WL[tree.parent[first]] @ tree.X_PF[first])[2, 3])
