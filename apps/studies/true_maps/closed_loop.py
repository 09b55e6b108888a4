"""Runs to the worst places of maps of thin and curved objects.

Offline maps are made from the disturbed capture, if `remosplat run` accepts
them. Live maps are made from exact frames, since a robot that moves its own
camera rejects others.
"""

from collections.abc import Iterator

import numpy as np

from apps.studies.attacks import (
    QUERIES,
    Aim,
    Attack,
    Attacks,
    Places,
    attack,
    attack_scenario,
)
from apps.studies.true_maps.case import Case
from apps.studies.true_maps.judge import (
    laid_on_truth,
    random_queries,
    worst_queries,
)
from apps.studies.true_maps.ray_casting import RayCaster
from apps.studies.true_maps.rods import live
from apps.studies.true_maps.scene import MeshScene
from apps.studies.true_maps.sight import Sight
from apps.studies.true_maps.trial import is_runnable, mapped
from remosplat_drake.app.scenario_robot import load_scenario_robot
from remosplat_drake.app.world import World
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

LIVE_FRAMES = 25
"""Number of frames of a live map."""

_START_CLEARANCE = 0.08
"""Least true clearance of the robot at its start [m]."""

_START_DISTANCE = 0.8, 1.5
"""Distance of the base's start from the middle of the workspace [m]."""

_START_DRAWS = 500
"""Number of random base positions after which a scene fails."""


def attack_case(aim: Aim) -> Attacks:
    """Makes all maps of a case and sends the robot to their worst places.

    Raises:
        Exception: Any error of the reconstruction or of a run.
    """
    case = aim.case
    assert isinstance(case, Case)
    sight = Sight(case.taken())
    truth, scenario = MeshTruth(sight), attack_scenario()
    robot = load_scenario_robot(scenario)
    q0 = _start(robot, truth, sight, np.random.default_rng([case.seed, 4]))
    runs: list[Attack] = []
    refused = []
    for name, splat_W, field in _maps(sight, robot, q0):
        if field is None:
            refused.append(name)
            continue
        raw = SphereToEllipsoidField(splat_W.with_uncertainty(None))
        places = find_places(sight, field, raw, case.seed)
        places = places.reachable(q0, sight.focus_W)
        world = World(robot, splat_W, None, field, q0)
        runs += attack(scenario, world, places, aim.count, truth, name)
    return Attacks(aim.key, tuple(runs), tuple(refused))


def _maps(
    sight: Sight, robot: RobotModel, q0: np.ndarray
) -> Iterator[tuple[str, GaussianSplat, DistanceField | None]]:
    """The maps by name, in W; no field if robots must not use the map."""
    taken = sight.taken
    made = mapped(taken.capture, sight.focus_W)
    splat_W = laid_on_truth(
        made.splat, made.alignment.capture.X_WC, taken.cameras.X_WC, sight
    )
    fits = not made.defects and is_runnable(made.report.remaining_error)
    yield "offline", splat_W, SphereToEllipsoidField(splat_W) if fits else None
    frames = taken.perfect()
    chosen = np.linspace(0, len(frames) - 1, LIVE_FRAMES).astype(int)
    frames = frames.select(np.unique(chosen))
    for name, unseen_is_solid in (
        ("live", False),
        ("live, unseen solid", True),
    ):
        grown = live(frames, unseen_is_solid, robot.spheres_at(q0))
        assert grown.splat_W is not None
        yield name, grown.splat_W, grown.field


def find_places(
    sight: Sight, field: DistanceField, raw: DistanceField, seed: int
) -> Places:
    """Finds true surface points, and a map's errors before them.

    Args:
        sight: The truth.
        field: The map that the robot uses.
        raw: The map without subtraction of its discs' uncertainty.
        seed: Seed of the random points.
    """
    rng = np.random.default_rng([seed, 3])
    queries = random_queries(sight, QUERIES, rng)
    queries = queries.joined(worst_queries(raw, sight, rng)).well_seen()
    queries = queries.selected(queries.wide)
    p_W = sight.taken.caster.nearest(queries.p_W).p_W
    inward_W = (p_W - queries.p_W) / queries.distance[:, None]
    return Places(
        p_W,
        inward_W,
        queries.over_estimates(field),
        queries.over_estimates(raw),
    )


class MeshTruth:
    """Evaluates runs with the scene's meshes; see `attacks.Truth`.

    Wheels stand on the floor, which is not an obstacle for the spheres that
    ignore it.

    Args:
        sight: The truth.
    """

    def __init__(self, sight: Sight):
        self._sight = sight
        parts = sight.taken.scene.parts
        self._number = np.array(
            [i for i, part in enumerate(parts) if part.label != "floor"]
        )
        above = MeshScene(tuple(parts[i] for i in self._number), np.zeros(3))
        self._above = RayCaster(above)

    def judged(self, robot: RobotModel, q: np.ndarray) -> tuple[float, float]:
        """Judges configurations; see `attacks.Truth.judged`."""
        placed = [robot.spheres_at(each) for each in q]
        p_WS = np.concatenate([spheres.p_WS for spheres in placed])
        radius = np.concatenate([spheres.radius for spheres in placed])
        on_floor = np.concatenate([s.ignore_below for s in placed]) > -np.inf
        near = self._above.nearest(p_WS)
        distance = near.distance - radius
        # The floor is level at z = 0.
        floor = (p_WS[:, 2] - radius)[~on_floor]
        smallest = min(distance.min(), floor.min())
        touched = near.selected(distance < 0)
        touched.part[:] = self._number[touched.part]
        seen, wide = self._sight.seen(touched)
        depth = (-distance[distance < 0][seen & wide]).max(initial=0.0)
        return float(smallest), float(depth)


def _start(
    robot: RobotModel, truth: MeshTruth, sight: Sight, rng: np.random.Generator
) -> np.ndarray:
    """A configuration in front of the table, clear of all surfaces."""
    scene = sight.taken.scene
    for _ in range(_START_DRAWS):
        angle = scene.open_to + rng.uniform(-1, 1) * scene.open_by
        away = rng.uniform(*_START_DISTANCE)
        x, y = scene.focus_W[:2] + away * np.array(
            [np.cos(angle), np.sin(angle)]
        )
        q0 = np.array([x, y, angle + np.pi, *robot.home])
        clearance, _ = truth.judged(robot, q0[None])
        if clearance > _START_CLEARANCE:
            return q0
    raise RemoSplatError("the scene leaves no room for the robot")
