"""Runs that are aimed at the worst places of a map, judged by the truth.

The hand is sent to true points of surfaces where the map, careful as it is, is
most wrong: it goes as near as its controller believes that it may.
"""

import dataclasses as dc

import numpy as np

from apps.studies.map_bound.case import Case
from apps.studies.map_bound.judge import (
    SEEN_BY,
    Sight,
    random_queries,
    times_seen,
    worst_queries,
)
from apps.studies.map_bound.trial import Mapped, make_map
from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.scenario_robot import load_scenario_robot
from remosplat_drake.app.simulation import run
from remosplat_drake.app.target_config import TargetConfig
from remosplat_drake.app.world import World
from remosplat_drake.benchmark.methods import load_methods
from remosplat_drake.benchmark.metrics import between_ticks
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres

METHOD, SECONDS = "ellipsoid-tuned", 10.0
"""The benchmark's method that drives, and for how long [s]: guidance would not
even set out for what cannot be reached."""

QUERIES = 5_000
"""Number of random points among which the worst places are looked for."""

_APART = 0.1
"""Distance of the places of one map from each other [m]."""

_REACH = 0.5
"""Distance up to which such places are from the scene's target, which the hand
can get to [m]."""

_PARTS = 3
"""Parts of a tick, between which distances are measured as well."""


@dc.dataclass(frozen=True)
class Attack:
    """What came of one run; all lengths in metres.

    Attributes:
        key: Name of the case, and the number of the place in its map.
        excess: By how much the distance that the robot works with exceeds the
            true one at the place.
        over: The same, of the map without its discs' uncertainty.
        clearance: Smallest true distance of the robot in the run.
        depth: How far it went into surfaces that were seen, at most; 0 for
            not at all.
        nearest: Smallest distance of the hand from the place.
        error: What went wrong; empty for nothing.
    """

    key: str
    excess: float = np.nan
    over: float = np.nan
    clearance: float = np.nan
    depth: float = np.nan
    nearest: float = np.nan
    error: str = ""


@dc.dataclass(frozen=True)
class Aim:
    """A case whose map is attacked.

    Attributes:
        case: The case.
        count: Number of runs.
    """

    case: Case
    count: int


def failed(aim: Aim, error: str) -> list[Attack]:
    """Returns the result of an aim whose map or runs failed."""
    return [Attack(aim.case.key, error=error)]


def attack(aim: Aim) -> list[Attack]:
    """Reconstructs a case and sends the robot to the worst places of its map.

    Raises:
        Exception: Any error of the reconstruction or of a run.
    """
    mapped = make_map(aim.case)
    scenario = load_methods([METHOD])[0].scenario
    scenario = dc.replace(scenario, time_limit=SECONDS)
    robot = load_scenario_robot(scenario)
    places = worst_places(mapped, aim.count, aim.case.seed)
    results = []
    for number, place in enumerate(places):
        q = _driven(scenario, robot, mapped, place.X_WE)
        clearance, depth = _judged(robot, q, mapped.sight)
        p_WE = np.array([robot.end_effector_pose(each)[:3, 3] for each in q])
        nearest = np.linalg.norm(p_WE - place.X_WE[:3, 3], axis=1).min()
        results.append(
            Attack(
                f"{aim.case.key}-{number}",
                place.excess,
                place.over,
                clearance,
                depth,
                float(nearest),
            )
        )
    return results


@dc.dataclass(frozen=True, eq=False)
class Place:
    """A place where a map is wrong.

    Attributes:
        X_WE: Pose of the hand at the true surface, facing it, shape (4, 4).
        excess: See `Attack`.
        over: See `Attack`.
    """

    X_WE: np.ndarray
    excess: float
    over: float


def worst_places(mapped: Mapped, count: int, seed: int) -> list[Place]:
    """Finds the places where distances less their uncertainty are worst.

    Args:
        mapped: The map and the truth.
        count: Largest number of places.
        seed: Seed of the points that are looked at.
    """
    rng = np.random.default_rng([seed, 3])
    raw = SphereToEllipsoidField(mapped.splat.with_uncertainty(None))
    queries = random_queries(mapped.sight, QUERIES, rng)
    queries = queries.joined(worst_queries(raw, mapped.sight, rng)).well_seen()
    truth = SignedDistanceField(mapped.sight.scene)
    surface = truth.clearances(Spheres.at(queries.p_W))
    excess = queries.over_estimates(SphereToEllipsoidField(mapped.splat))
    reachable = _is_reachable(mapped.sight, surface.p_WC, surface.direction_W)
    chosen: list[int] = []
    for i in np.argsort(-excess, kind="stable").tolist():
        apart = np.linalg.norm(
            surface.p_WC[chosen] - surface.p_WC[i], axis=1
        ).min(initial=np.inf)
        if apart > _APART and reachable[i]:
            chosen.append(i)
        if len(chosen) == count:
            break
    over = queries.over_estimates(raw)
    return [
        Place(
            _facing(surface.p_WC[i], surface.direction_W[i]),
            float(excess[i]),
            float(over[i]),
        )
        for i in chosen
    ]


def _is_reachable(
    sight: Sight, p_W: np.ndarray, inward_W: np.ndarray
) -> np.ndarray:
    """Which surface points (n, 3) the hand may get to from where it starts."""
    target_W, start = sight.focus_W, sight.scene.X_WB_start
    assert start is not None
    ahead_W = target_W - [start[0], start[1], target_W[2]]
    near = np.linalg.norm(p_W - target_W, axis=1) < _REACH
    return near & ((inward_W @ ahead_W > 0) | (inward_W[:, 2] < 0))


def _facing(p_W: np.ndarray, inward_W: np.ndarray) -> np.ndarray:
    """The pose at a point whose z axis is a given one, shape (4, 4)."""
    across = np.cross(inward_W, np.eye(3)[np.abs(inward_W).argmin()])
    across /= np.linalg.norm(across)
    X = np.eye(4)
    X[:3, :3] = np.stack([across, np.cross(inward_W, across), inward_W], axis=1)
    X[:3, 3] = p_W
    return X


def _driven(
    scenario: Scenario, robot: RobotModel, mapped: Mapped, X_WE: np.ndarray
) -> np.ndarray:
    """Configurations of a run towards a pose, at ticks and between."""
    target = TargetConfig(X_WE[:3, 3].tolist(), rotation=X_WE[:3, :3].tolist())
    scenario = dc.replace(scenario, targets=[target])
    start = mapped.sight.scene.X_WB_start
    assert start is not None
    q0 = np.array([*start, *robot.home])
    field = SphereToEllipsoidField(mapped.splat)
    world = World(robot, mapped.splat, mapped.sight.scene, field, q0)
    q = run(build(scenario, world)).trajectory.q
    between = between_ticks(q, _PARTS).reshape(-1, q.shape[1])
    return np.concatenate([q, between])


def _judged(
    robot: RobotModel, q: np.ndarray, sight: Sight
) -> tuple[float, float]:
    """The smallest true distance, and the depth in surfaces that were seen."""
    truth = SignedDistanceField(sight.scene)
    smallest, depth = np.inf, 0.0
    for each in q:
        near = truth.clearances(robot.spheres_at(each))
        smallest = min(smallest, near.minimum())
        inside = near.distance < 0
        if inside.any():
            views = times_seen(
                near.p_WC[inside], near.direction_W[inside], sight
            )
            seen = near.distance[inside][views >= SEEN_BY]
            depth = max(depth, -float(seen.min(initial=0.0)))
    return float(smallest), depth


def summary(attacks: list[Attack]) -> list[str]:
    """Words what came of all runs, a line each."""
    good = [a for a in attacks if not a.error]
    lines = [f"{len(good)} runs aimed at the worst places of maps"]
    if not good:
        return lines
    touched = sum(a.clearance <= 0 for a in good)
    seen = sum(a.depth > 0 for a in good)
    clearance = 1e3 * np.array([a.clearance for a in good])
    return [
        *lines,
        f"touches: {touched}, of surfaces that two views saw well: {seen}",
        f"true clearance: {clearance.min():.1f} mm at least,"
        f" {np.median(clearance):.1f} mm (median)",
        f"over-estimates there: {1e3 * max(a.over for a in good):.1f} mm at"
        f" most, less uncertainty {1e3 * max(a.excess for a in good):.1f} mm;"
        f" the hand came as near as"
        f" {1e3 * np.median([a.nearest for a in good]):.0f} mm (median)",
    ]
