"""Closed loops along a path with speeds: on time, late, and pushed."""

import dataclasses as dc
from itertools import pairwise

import numpy as np
import pytest

from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.planning.blending import blended_corners
from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.timing import TimingLimits, timed_path
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.program.path import Path
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.primitive_scene import PrimitiveScene

DT = 0.02
NOTHING = SignedDistanceField(PrimitiveScene())


@pytest.fixture(scope="module")
def panda() -> RobotModel:
    return load_robot("panda")


@dc.dataclass
class Loop:
    """An arm that follows a path where nothing else is.

    Attributes:
        law: The control law.
        guidance: The guidance with the path.
        q: Where the arm is.
        u: The command being executed.
    """

    law: ReactiveLaw
    guidance: Guidance
    q: np.ndarray
    u: np.ndarray

    @staticmethod
    def make(robot: RobotModel, corners: np.ndarray) -> "Loop":
        config = gain_set("fast")
        law = ReactiveLaw.make(config, robot, DT)
        bounds = robot.position_lower, robot.position_upper
        space = FreeSpace(robot, NOTHING, 0.021, None, bounds, corners[0])
        limits = TimingLimits(law.collision, 1.0, DT)
        path = timed_path(space, blended_corners(space, corners, 1.0), limits)
        guidance = Guidance("plan", active_scale=0.0, path=path, joint_stop=0.1)
        return Loop(law, guidance, corners[0], np.zeros(robot.n_u))

    def tick(self, X_WT: np.ndarray) -> np.ndarray:
        robot = self.law.robot
        report = run_tick(
            self.law,
            0.0,
            self.q,
            X_WT,
            NOTHING.clearances(robot.spheres_at(self.q)),
            NOTHING,
            self.u,
            self.guidance,
        )
        self.u = report.command
        self.q = robot.advance(self.q, self.u, DT)
        return self.u

    def left(self) -> float:
        path = self.guidance.path
        assert path is not None
        s, apart = path.nearest(self.q)
        return path.length - s + apart


def corners_for(robot: RobotModel) -> np.ndarray:
    first = robot.home
    second = first + np.array([0.8, 0.3, -0.2, 0.4, 0.1, -0.3, 0.5])
    third = second + np.array([0.2, -0.6, 0.3, -0.5, 0.4, 0.6, -0.2])
    return np.array([first, second, third])


def followed(loop: Loop, X_WT: np.ndarray, most: int = 200) -> np.ndarray:
    """Drives to the path's end; returns the commands, shape (T, n_u)."""
    commands = []
    while loop.left() > 0.02 and len(commands) < most:
        commands.append(loop.tick(X_WT))
    assert loop.left() <= 0.02
    return np.array(commands)


def test_a_path_takes_little_longer_than_the_limits_ask(panda):
    corners = corners_for(panda)
    loop = Loop.make(panda, corners)
    u = followed(loop, panda.end_effector_pose(corners[-1]))
    straight = sum(
        np.abs((b - a) / panda.velocity_limit).max()
        for a, b in pairwise(corners)
    )
    # Each of the slowest joints needs v / a = 0.3 s more to start and stop.
    assert len(u) * DT < straight + 0.6
    change = np.diff(u, axis=0, prepend=np.zeros((1, panda.n_u)))
    assert (np.abs(u) <= panda.velocity_limit + 1e-6).all()
    assert (np.abs(change) <= panda.acceleration_limit * DT + 1e-6).all()


def test_a_pushed_arm_goes_on_from_where_it_is(panda):
    """It is held up, and pushed aside: no command jumps, and it comes back."""
    corners = corners_for(panda)
    X_WT = panda.end_effector_pose(corners[-1])
    loop = Loop.make(panda, corners)
    undisturbed = len(followed(Loop.make(panda, corners), X_WT))
    for _ in range(15):
        loop.tick(X_WT)
    loop.q = loop.q + 0.05 * np.array([1.0, -1, 1, 0, 0, 0, 0])
    loop.u = np.zeros(panda.n_u)
    rest = followed(loop, X_WT)
    change = np.diff(rest, axis=0, prepend=np.zeros((1, panda.n_u)))
    assert (np.abs(change) <= panda.acceleration_limit * DT + 1e-6).all()
    # It begins from rest again, and that is all that it has lost.
    assert 15 + len(rest) < undisturbed + 25


def test_a_base_beside_the_end_of_its_path_reaches_the_target(frankie):
    """The base cannot slip back, so the arm leaves the path's end."""
    end = frankie.q_home
    before = end - 0.4 * np.array([np.cos(end[2]), np.sin(end[2]), *[0] * 8])
    aside = np.array([-np.sin(end[2]), np.cos(end[2]), *[0] * 8])
    guidance = Guidance("plan", path=Path.through(np.array([before, end])))
    loop = Loop(
        ReactiveLaw.make(gain_set("fast"), frankie, DT),
        guidance,
        end + 0.09 * aside,
        np.zeros(frankie.n_u),
    )
    X_WT = frankie.end_effector_pose(end)
    for _ in range(300):
        loop.tick(X_WT)
    X_WE = frankie.end_effector_pose(loop.q)
    assert np.linalg.norm(X_WE[:3, 3] - X_WT[:3, 3]) < 1e-3
