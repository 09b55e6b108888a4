"""Runs to the worst places of a map, evaluated with the truth.

The hand is sent to true surface points with the largest over-estimates of the
map, and approaches as far as its controller permits.
"""

import dataclasses as dc
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.target_config import TargetConfig
from remosplat_drake.app.world import World
from remosplat_drake.benchmark.methods import load_methods
from remosplat_drake.benchmark.metrics import between_ticks
from remosplat_drake.robot.robot_model import RobotModel

METHOD, SECONDS = "ellipsoid-tuned", 10.0
"""Method of the benchmark that drives the robot, and the time limit of a run
[s]. The method has no guidance, since guidance does not move the robot towards
unreachable targets."""

QUERIES = 5_000
"""Number of random points among which the worst places are searched."""

_APART = 0.1
"""The chosen places of a map are farther than this from each other [m]."""

_REACH = 0.5
"""Places count as reachable only if they are nearer than this to the middle of
the workspace [m]."""

_PARTS = 3
"""Each tick is divided into this many parts. Distances are measured at the end
of each part."""


@dc.dataclass(frozen=True, eq=False)
class Places:
    """n true surface points, and a map's errors there.

    Attributes:
        p_W: The points, shape (n, 3) [m].
        inward_W: Directions in which they are approached, shape (n, 3).
        excess: In front of each point, the robot's distance minus the true
            distance, shape (n,) [m].
        over: The excess without subtraction of the discs' uncertainty.
    """

    p_W: np.ndarray
    inward_W: np.ndarray
    excess: np.ndarray
    over: np.ndarray

    def reachable(self, start: np.ndarray, focus_W: np.ndarray) -> "Places":
        """Returns the places that the hand may reach.

        Args:
            start: Start of the base: x, y and more, shape (2..,) [m].
            focus_W: Middle of the workspace, shape (3,) [m].
        """
        ahead_W = np.array([*(focus_W[:2] - start[:2]), 0])
        near = np.linalg.norm(self.p_W - focus_W, axis=1) < _REACH
        is_before = self.inward_W @ ahead_W > 0
        return self._selected(near & (is_before | (self.inward_W[:, 2] < 0)))

    def worst(self, count: int) -> list[int]:
        """Returns the indices of the worst places that are far enough apart.

        Args:
            count: At most this many places are returned.
        """
        chosen: list[int] = []
        for i in np.argsort(-self.excess, kind="stable").tolist():
            away = np.linalg.norm(self.p_W[chosen] - self.p_W[i], axis=1)
            if away.min(initial=np.inf) > _APART:
                chosen.append(i)
            if len(chosen) == count:
                break
        return chosen

    def _selected(self, keep: np.ndarray) -> "Places":
        return Places(
            *(getattr(self, field.name)[keep] for field in dc.fields(self))
        )

    def X_WE(self, i: int) -> np.ndarray:
        """The hand's pose at place i, z axis inward, shape (4, 4)."""
        inward_W = self.inward_W[i]
        across = np.cross(inward_W, np.eye(3)[np.abs(inward_W).argmin()])
        across /= np.linalg.norm(across)
        down = np.cross(inward_W, across)
        X_WE = np.eye(4)
        X_WE[:3, :3] = np.stack([across, down, inward_W], axis=1)
        X_WE[:3, 3] = self.p_W[i]
        return X_WE


class Truth(Protocol):
    """The true geometry of a scene."""

    def judged(self, robot: RobotModel, q: np.ndarray) -> tuple[float, float]:
        """Evaluates the robot's distances in configurations (n, n_q).

        Returns:
            The robot's smallest true distance, and its largest penetration of
            seen surfaces [m].
        """
        ...


@dc.dataclass(frozen=True)
class Attack:
    """Result of one run; all lengths in metres.

    Attributes:
        map: Name of the method that made the map; empty if there is one only.
        excess: The robot's distance minus the true distance at the place.
        over: The excess without subtraction of the discs' uncertainty.
        clearance: Smallest true distance of the robot in the run.
        depth: Largest penetration of seen surfaces; 0 for none.
        nearest: Smallest distance of the hand from the place.
    """

    map: str
    excess: float
    over: float
    clearance: float
    depth: float
    nearest: float


@dc.dataclass(frozen=True)
class Attacks:
    """Results of the runs on the maps of one case.

    Attributes:
        key: Name of the case.
        runs: The runs.
        refused: Maps that robots must not use, each with the reason.
        error: Error text; empty without an error.
    """

    key: str
    runs: tuple[Attack, ...] = ()
    refused: tuple[str, ...] = ()
    error: str = ""


class Case(Protocol):
    """A case of a study."""

    @property
    def key(self) -> str:
        """Name of the case, unique."""
        ...


@dc.dataclass(frozen=True)
class Aim:
    """A case whose maps are attacked.

    Attributes:
        case: The case.
        count: Largest number of runs on each map.
    """

    case: Case
    count: int

    @property
    def key(self) -> str:
        """Name of the case, and the number of runs on each map."""
        return f"{self.case.key}, {self.count} places"


def failed(aim: Aim, error: str) -> Attacks:
    """Returns the result of an aim whose maps or runs failed."""
    return Attacks(aim.key, error=error)


def restored(fields: dict[str, Any]) -> Attacks:
    """Restores a result from a line of a results' file."""
    fields["runs"] = tuple(Attack(**run) for run in fields["runs"])
    fields["refused"] = tuple(fields["refused"])
    return Attacks(**fields)


def attack_scenario() -> Scenario:
    """Returns the scenario of a run, without a map and a target."""
    scenario = load_methods([METHOD])[0].scenario
    return dc.replace(scenario, time_limit=SECONDS)


def attack(
    scenario: Scenario,
    world: World,
    places: Places,
    count: int,
    truth: Truth,
    name: str = "",
) -> list[Attack]:
    """Sends the robot to the worst places of a map.

    Args:
        scenario: The result of `attack_scenario`.
        world: The robot, its start, and the map.
        places: Places that the robot may reach.
        count: Largest number of runs.
        truth: The reference for the runs.
        name: Name of the method that made the map.
    """
    robot, attacks = world.robot, []
    for i in places.worst(count):
        q = _driven(scenario, world, places.X_WE(i))
        clearance, depth = truth.judged(robot, q)
        p_WE = np.array([robot.end_effector_pose(each)[:3, 3] for each in q])
        attacks.append(
            Attack(
                name,
                float(places.excess[i]),
                float(places.over[i]),
                clearance,
                depth,
                float(np.linalg.norm(p_WE - places.p_W[i], axis=1).min()),
            )
        )
    return attacks


def _driven(scenario: Scenario, world: World, X_WE: np.ndarray) -> np.ndarray:
    """Configurations of a run towards a pose, at ticks and between."""
    target = TargetConfig(X_WE[:3, 3].tolist(), rotation=X_WE[:3, :3].tolist())
    scenario = dc.replace(scenario, targets=[target])
    q = run(build(scenario, world)).trajectory.q
    between = between_ticks(q, _PARTS).reshape(-1, q.shape[1])
    return np.concatenate([q, between])


def summary(results: Sequence[Attacks]) -> list[str]:
    """Summarises all runs, one line each."""
    runs = [each for result in results for each in result.runs]
    refused = [reason for result in results for reason in result.refused]
    lines = [f"{len(runs)} runs aimed at the worst places of maps"]
    if refused:
        lines.append(f"{len(refused)} maps that robots must not use")
    lines += [
        f"{r.key}: {r.error.splitlines()[-1]}" for r in results if r.error
    ]
    for name in dict.fromkeys(each.map for each in runs):
        of_map = [each for each in runs if each.map == name]
        if name:
            lines.append(f"{name}: {len(of_map)} runs")
        lines += _described(of_map)
    return lines


def _described(runs: Sequence[Attack]) -> list[str]:
    """Summarises the runs on maps of one kind."""
    touched = sum(a.clearance <= 0 for a in runs)
    seen = sum(a.depth > 0 for a in runs)
    clearance = 1e3 * np.array([a.clearance for a in runs])
    nearest = 1e3 * np.median([a.nearest for a in runs])
    return [
        f"touches: {touched}, of surfaces that two views saw well: {seen}",
        f"true clearance: {clearance.min():.1f} mm at least,"
        f" {np.median(clearance):.1f} mm (median)",
        f"over-estimates there: {1e3 * max(a.over for a in runs):.1f} mm at"
        f" most, less uncertainty {1e3 * max(a.excess for a in runs):.1f} mm;"
        f" the hand came as near as {nearest:.0f} mm (median)",
    ]
