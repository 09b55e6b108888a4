"""Starts that a robot must get out of: too near to itself or to the scene."""

import dataclasses as dc
from functools import cache

import numpy as np

from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.world import World, load_world, scenario_targets
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.signals.target import Target

SCENARIOS = {
    "frankie": "TableReach",
    "panda": "PandaReach",
    "ur5e": "Ur5eReach",
    "fetch": "FetchReach",
    "ridgeback_panda": "RidgebackReach",
    "two_pandas": "TwoPandasReach",
}
"""Where each robot starts: a scenario that is shipped."""

DEEPEST = 0.03
"""How far inside its distances a start is at most [m]."""

_AROUND = 0.8
"""How far from the scenario's start a base is put, either way [m]."""

_DRAWS = 20_000
"""Configurations after which a start is given up."""


@dc.dataclass(frozen=True)
class Start:
    """A start, drawn from a seed.

    Attributes:
        robot: Name of the robot, a key of `SCENARIOS`.
        seed: Where its configuration comes from.
    """

    robot: str
    seed: int

    @property
    def key(self) -> str:
        """Name of the start among all starts."""
        return f"{self.robot} {self.seed}"


@dc.dataclass(frozen=True, eq=False)
class Place:
    """Where a robot starts, and what it is driven by.

    Attributes:
        scenario: The scenario.
        world: What its files hold.
        law: The control law.
        target: Where the robot is to go.
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

    def margins(self, q: np.ndarray) -> np.ndarray:
        """Computes what distances have above their stopping distances.

        Args:
            q: Configuration, shape (n_q,) [rad, m].

        Returns:
            Those of all pairs of the robot's shapes, then those of all spheres
            from the map, shape (k + n,) [m]; at most a few centimetres.
        """
        own, stopping = self.own, self.law.collision.stopping
        itself = own.distances(q, own.stopping + DEEPEST) - own.stopping
        spheres = self.world.robot.spheres_at(q)
        near = self.world.field.clearances(spheres, stopping + DEEPEST)
        scene = near.per_sphere(len(spheres)) - stopping
        return np.minimum(np.concatenate([itself, scene]), DEEPEST)


@cache
def place_of(robot: str) -> Place:
    """Loads where a robot starts.

    Args:
        robot: A key of `SCENARIOS`.
    """
    scenario = load_scenario(SCENARIOS[robot])
    scenario.controller.solver = "active_set"
    world = load_world(scenario)
    law = ReactiveLaw.make(
        scenario.controller, world.robot, scenario.control_period
    )
    targets = scenario_targets(scenario, world.truth, world.robot.effectors)
    first = next(iter(targets.values()))[0]
    return Place(scenario, world, law, first)


def draw(start: Start) -> np.ndarray:
    """Draws the configuration of a start, shape (n_q,) [rad, m].

    Joints are anywhere within their limits, and a base is near where its
    scenario begins.

    Args:
        start: The start.

    Raises:
        RemoSplatError: None is found.
    """
    random = np.random.default_rng([start.seed, len(start.robot)])
    place = place_of(start.robot)
    robot, q0 = place.world.robot, place.world.q0
    turn = np.where(np.arange(robot.n_q) == 2, np.pi, _AROUND)
    base = len(q0) - len(robot.home)
    for _ in range(_DRAWS):
        q = q0 + turn * random.uniform(-1, 1, robot.n_q)
        lower = np.maximum(robot.position_lower, -np.pi)[base:]
        upper = np.minimum(robot.position_upper, np.pi)[base:]
        q[base:] = random.uniform(lower, upper)
        if -DEEPEST <= place.margins(q).min() < 0:
            return q
    raise RemoSplatError(f"{start.key}: no start found in {_DRAWS} draws")
