"""A start executes exactly the motion that verification has seen."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.safety.supervision import Observation, SupervisorLaw
from remosplat_drake.safety.supervisor import supervise
from remosplat_drake.safety.supervisor_config import SupervisorConfig
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.signals.supervisor_state import STOPPED, SupervisorState

WALL = PrimitiveScene(
    boxes=(Box(RigidTransform([1.08, 0, 0.5]), np.array([0.1, 2, 2])),)
)
FIELD = SignedDistanceField(WALL)


class Push:
    """A cost that pulls the command to p, however far from the present one."""

    def __init__(self, p: np.ndarray):
        self.p = p

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        program.add_quadratic_cost("push", np.ones(program.n_u))
        program.add_linear_cost("push", -self.p)


class Cycles:
    """A robot that is set going and stopped again, and pushed meanwhile."""

    def __init__(self, robot: RobotModel, q: np.ndarray, dt: float):
        self.robot, self.q, self.dt, self.k = robot, q, dt, 0
        self.push = Push(np.zeros(robot.n_u))
        # No bounds on accelerations: from rest, commands jump.
        self.law = ReactiveLaw(robot, [self.push], dt, solver="active_set")
        self.supervision = SupervisorLaw.make(
            SupervisorConfig(clearance_margin=0.05),
            robot,
            dt,
            smallest_stopping=self.law.collision.stopping,
        )
        self.state = SupervisorState(np.zeros(robot.n_u))
        self.least = np.inf

    def clearances(self):
        return FIELD.clearances(self.robot.spheres_at(self.q), 0.5)

    def towards(self) -> np.ndarray:
        """The direction of u that brings the nearest sphere nearer."""
        near, state = self.clearances(), self.robot.state(self.q)
        row = int(near.distance.argmin())
        rate = near.direction_W[row] @ state.Jv_WS[near.sphere[row]]
        return rate / np.linalg.norm(rate)

    def approach(self) -> None:
        """Goes as near as it may."""
        for _ in range(round(2.0 / self.dt)):
            self.push.p[:] = self.towards()
            self.tick()

    def along(self, rng: np.random.Generator) -> np.ndarray:
        """A command along the scene, and a little towards it.

        On the way to its next look, such a path may come nearer than it is
        where it was looked at.
        """
        towards = self.towards()
        u = rng.normal(size=self.robot.n_u)
        u += (rng.choice([0.02, 0.1, 0.5]) - towards @ u) * towards
        return rng.choice([0.2, 0.5, 1.0, 2.0]) * u / np.abs(u).max()

    def tick(self, *, stop: str = "", release: bool = False) -> None:
        time = self.k * self.dt
        report = run_tick(
            self.law,
            time,
            self.q,
            np.eye(4),
            self.clearances(),
            FIELD,
            self.state.command,
        )
        now = Observation(
            time=time,
            command=report.command,
            report=report,
            status=StationStatus(),
            u_measured=self.state.command,
            stop=stop,
            release=release,
        )
        self.state = supervise(self.supervision, self.state, now)
        self.q = self.robot.advance(self.q, self.state.command, self.dt)
        self.least = min(self.least, self.clearances().minimum())
        self.k += 1

    def cycle(self, rng: np.random.Generator) -> None:
        """Starts, moves for some ticks, stops, and is released."""
        for _ in range(rng.integers(1, 4)):
            self.push.p[:] = self.along(rng)
            self.tick()
        self.tick(stop="test")
        while self.state.mode != STOPPED:
            self.tick()
        self.tick(release=True)


@pytest.mark.parametrize("dt", [0.01, 0.1])
@pytest.mark.parametrize("seed", range(3))
def test_starts_and_stops_do_not_creep_towards_the_scene(three_link, dt, seed):
    rng = np.random.default_rng(seed)
    cycles = Cycles(three_link, np.array([0.3, -0.8, 0.2]), dt)
    level = min(cycles.law.collision.stopping, cycles.clearances().minimum())
    travelled = 0.0
    cycles.approach()
    for _ in range(120):
        before = cycles.q
        cycles.cycle(rng)
        travelled += float(np.abs(cycles.q - before).max())
    assert travelled > 1.0
    assert cycles.least < level + 0.01  # They came as near as they may.
    assert cycles.least >= level - 1e-12
