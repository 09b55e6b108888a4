"""Runs to the worst places of this study's maps."""

import numpy as np

from apps.studies.attacks import (
    QUERIES,
    Aim,
    Attacks,
    Places,
    attack,
    attack_scenario,
)
from apps.studies.map_bound.case import Case
from apps.studies.map_bound.judge import (
    SEEN_BY,
    Sight,
    random_queries,
    times_seen,
    worst_queries,
)
from apps.studies.map_bound.trial import Mapped, make_map
from remosplat_drake.app.scenario_robot import load_scenario_robot
from remosplat_drake.app.world import World
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres


def attack_case(aim: Aim) -> Attacks:
    """Reconstructs a case and sends the robot to the worst places of its map.

    Raises:
        Exception: Any error of the reconstruction or of a run.
    """
    case = aim.case
    assert isinstance(case, Case)
    mapped = make_map(case)
    scene, scenario = mapped.sight.scene, attack_scenario()
    robot = load_scenario_robot(scenario)
    assert scene.X_WB_start is not None
    q0 = np.array([*scene.X_WB_start, *robot.home])
    field = SphereToEllipsoidField(mapped.splat)
    world = World(robot, mapped.splat, scene, field, q0)
    places = find_places(mapped, case.seed).reachable(q0, mapped.sight.focus_W)
    truth = SceneTruth(mapped.sight)
    runs = attack(scenario, world, places, aim.count, truth)
    return Attacks(aim.key, tuple(runs))


def find_places(mapped: Mapped, seed: int) -> Places:
    """Finds true surface points, and the map's errors before them.

    Args:
        mapped: The map and the truth.
        seed: Seed of the random points.
    """
    sight, rng = mapped.sight, np.random.default_rng([seed, 3])
    raw = SphereToEllipsoidField(mapped.splat.with_uncertainty(None))
    careful = SphereToEllipsoidField(mapped.splat)
    queries = random_queries(sight, QUERIES, rng)
    queries = queries.joined(worst_queries(raw, sight, rng)).well_seen()
    surface = SignedDistanceField(sight.scene).clearances(
        Spheres.at(queries.p_W)
    )
    return Places(
        surface.p_WC,
        surface.direction_W,
        queries.over_estimates(careful),
        queries.over_estimates(raw),
    )


class SceneTruth:
    """Judges runs by the scene's solids; see `attacks.Truth`.

    Args:
        sight: The truth.
    """

    def __init__(self, sight: Sight):
        self._sight = sight

    def judged(self, robot: RobotModel, q: np.ndarray) -> tuple[float, float]:
        """Judges configurations; see `attacks.Truth.judged`."""
        truth = SignedDistanceField(self._sight.scene)
        smallest, depth = np.inf, 0.0
        for each in q:
            near = truth.clearances(robot.spheres_at(each))
            smallest = min(smallest, near.minimum())
            inside = near.distance < 0
            if inside.any():
                views = times_seen(
                    near.p_WC[inside], near.direction_W[inside], self._sight
                )
                seen = near.distance[inside][views >= SEEN_BY]
                depth = max(depth, -float(seen.min(initial=0.0)))
        return float(smallest), depth
