"""Starts with a violated stopping distance, which a robot must leave."""

import dataclasses as dc
from functools import cache

import numpy as np

from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.scene_config import OBSTACLE
from remosplat_drake.app.world import World, load_world, scenario_targets
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.program.joint_margins import (
    STOP_SHARE,
    joint_margins,
)
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals.near_movers import NearMovers
from remosplat_drake.signals.target import Target

SCENARIOS = {
    "frankie": "TableReach",
    "panda": "PandaReach",
    "ur5e": "Ur5eReach",
    "fetch": "FetchReach",
    "ridgeback_panda": "RidgebackReach",
    "two_pandas": "TwoPandasReach",
}
"""Shipped scenario of each robot."""

SURROUNDINGS, UNSEEN, JOINTS, MOVER = (
    "surroundings",
    "unseen",
    "joints",
    "mover",
)
KINDS = SURROUNDINGS, UNSEEN, JOINTS, MOVER
"""Kinds of violated distances: between links or from the scene, from unseen
space, from joint limits, from a mover at rest."""

DEEPEST = 0.03
"""Largest violation of a stopping distance at a start [m]."""

_AROUND = 0.8
"""The base is at most this far from the scenario's start, along each axis
[m]."""

_DRAWS = 20_000
"""Number of random configurations after which a start fails."""

_MOVER_RADIUS = 0.08
"""Radius of a mover, which is a sphere [m]."""


@dc.dataclass(frozen=True)
class Start:
    """A start, drawn from a seed.

    Attributes:
        robot: Name of the robot, a key of `SCENARIOS`.
        seed: Seed of its configuration.
        kind: Kind of violated distance, one of `KINDS`.
    """

    robot: str
    seed: int
    kind: str = SURROUNDINGS

    @property
    def key(self) -> str:
        """Name of the start among all starts."""
        return f"{self.robot} {self.kind} {self.seed}"


@dc.dataclass(frozen=True, eq=False)
class Place:
    """A robot's world, control law and target.

    Attributes:
        scenario: The scenario.
        world: The content of its files.
        law: The control law.
        target: Target of the robot.
    """

    scenario: Scenario
    world: World
    law: ReactiveLaw
    target: Target

    @property
    def own(self) -> SelfClearance:
        """The pairs of the robot's shapes, and the distance they keep."""
        own = self.law.self_clearance
        assert own is not None
        return own

    def margins(self, q: np.ndarray, movers: Movers) -> np.ndarray:
        """Computes the excess of distances over their stopping distances.

        Args:
            q: Configuration, shape (n_q,) [rad, m].
            movers: Movers, which are at rest.

        Returns:
            Those of all pairs of the robot's shapes, of all spheres from the
            map, and of all spheres from movers, shape (k + 2 n,) [m]; at most
            a few centimetres.
        """
        own, stopping = self.own, self.law.collision.stopping
        itself = own.distances(q, own.stopping + DEEPEST) - own.stopping
        spheres = self.world.robot.spheres_at(q)
        near = self.world.field.clearances(spheres, stopping + DEEPEST)
        scene = near.per_sphere(len(spheres)) - stopping
        apart, separation = np.full(len(spheres), DEEPEST), self.separation
        found = NearMovers.find(movers, 0.0, spheres, separation + DEEPEST)
        np.minimum.at(apart, found.sphere, found.distance - separation)
        return np.minimum(np.concatenate([itself, scene, apart]), DEEPEST)

    def joint_margins(self, q: np.ndarray) -> np.ndarray:
        """Computes the excess of joint distances over their stopping distances.

        Args:
            q: Configuration, shape (n_q,) [rad, m].

        Returns:
            The margins, shape (n_arm,) [rad, m]; zero if a distance is large
            enough.
        """
        robot, stop = self.world.robot, self.joint_stops
        inside = np.minimum(q - robot.position_lower, robot.position_upper - q)
        return np.minimum(inside[-len(stop) :] - stop, 0.0)

    @property
    def joint_stops(self) -> np.ndarray:
        """The distances that joints keep from limits, (n_arm,) [rad, m]."""
        config = self.scenario.controller.joint_limits
        hinge = np.radians(config.stop)
        return joint_margins(
            self.world.robot, hinge, config.slide_stop, STOP_SHARE
        )

    @property
    def separation(self) -> float:
        """The distance that spheres keep from movers [m]."""
        return self.law.movers.separation


@dc.dataclass(frozen=True, eq=False)
class Posture:
    """A random start.

    Attributes:
        q: The configuration, shape (n_q,) [rad, m].
        movers: Movers at rest beside the robot; none for most kinds.
    """

    q: np.ndarray
    movers: Movers


@cache
def place_of(robot: str, unseen_is_solid: bool = False) -> Place:
    """Loads the world and control law of a robot.

    Args:
        robot: A key of `SCENARIOS`.
        unseen_is_solid: Whether space that no camera has seen is an obstacle.
    """
    scenario = load_scenario(SCENARIOS[robot])
    scenario.controller.solver = "active_set"
    if unseen_is_solid:
        scenario.scene.unknown = OBSTACLE
    world = load_world(scenario)
    law = ReactiveLaw.make(
        scenario.controller, world.robot, scenario.control_period
    )
    targets = scenario_targets(scenario, world.truth, world.robot.effectors)
    first = next(iter(targets.values()))[0]
    return Place(scenario, world, law, first)


def has_unseen_space(robot: str) -> bool:
    """Returns whether the seen space of a robot's scenario is known.

    Args:
        robot: A key of `SCENARIOS`.
    """
    return place_of(robot, unseen_is_solid=True).world.seen is not None


def draw(start: Start) -> Posture:
    """Draws the posture of a start.

    Joints are uniform within their limits, and a base is near its scenario's
    start. Only distances of the start's kind are violated; joints may be near
    their limits in all kinds.

    Args:
        start: The start.

    Raises:
        RemoSplatError: No start is found.
    """
    kind = KINDS.index(start.kind)
    random = np.random.default_rng([start.seed, len(start.robot), kind])
    place = place_of(start.robot, start.kind == UNSEEN)
    known = place_of(start.robot)
    robot, nothing = place.world.robot, Movers(0.0, [])
    for _ in range(_DRAWS):
        q = _anywhere(place, random)
        if start.kind == JOINTS:
            q = _near_limits(place, q, random)
        least = place.margins(q, nothing).min()
        if start.kind in (JOINTS, MOVER):
            if least < 0.0:
                continue
            if start.kind == JOINTS:
                return Posture(q, nothing)
            movers = _beside(place, robot.spheres_at(q), random)
            if -DEEPEST <= place.margins(q, movers).min() < 0.0:
                return Posture(q, movers)
        elif -DEEPEST <= least < 0.0 and (
            start.kind != UNSEEN or known.margins(q, nothing).min() >= 0.0
        ):
            return Posture(q, nothing)
    raise RemoSplatError(f"{start.key}: no start found in {_DRAWS} draws")


def _anywhere(place: Place, random: np.random.Generator) -> np.ndarray:
    """Draws a configuration within joint limits, shape (n_q,)."""
    robot, q0 = place.world.robot, place.world.q0
    turn = np.where(np.arange(robot.n_q) == 2, np.pi, _AROUND)
    base = len(q0) - len(robot.home)
    q = q0 + turn * random.uniform(-1, 1, robot.n_q)
    lower = np.maximum(robot.position_lower, -np.pi)[base:]
    upper = np.minimum(robot.position_upper, np.pi)[base:]
    q[base:] = random.uniform(lower, upper)
    return q


def _near_limits(
    place: Place, q: np.ndarray, random: np.random.Generator
) -> np.ndarray:
    """Moves joints so close to limits that they may only move away."""
    robot, stop = place.world.robot, place.joint_stops
    n, q = len(stop), q.copy()
    bounded = np.isfinite(robot.position_upper - robot.position_lower)[-n:]
    chosen = random.random(n) < 0.2
    chosen[random.choice(np.flatnonzero(bounded))] = True
    for j in np.flatnonzero(chosen & bounded):
        i, depth = robot.n_q - n + j, random.uniform(0.0, stop[j])
        lower, upper = robot.position_lower[i], robot.position_upper[i]
        q[i] = random.choice([lower + depth, upper - depth])
    return q


def _beside(place: Place, spheres, random: np.random.Generator) -> Movers:
    """Places a mover at rest beside a sphere that the robot can move."""
    robot = place.world.robot
    moved = np.flatnonzero(np.abs(robot.jacobian_bound).max(axis=1) > 0.0)
    i = random.choice(moved)
    n_W = random.normal(size=3)
    n_W /= np.linalg.norm(n_W)
    gap = place.separation - random.uniform(0.0, DEEPEST)
    way = spheres.radius[i] + gap + _MOVER_RADIUS
    p_WM = spheres.p_WS[i] + way * n_W
    return Movers(0.0, [Mover.sphere("cart", p_WM, _MOVER_RADIUS)])
