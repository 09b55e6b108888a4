"""A maze for a small arm: the only way leads past a block with a bent elbow."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.guidance.selection_rule import (
    SelectionRule,
    make_selection_rule,
)
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.planning.planning_config import PlanningConfig
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

STOPPING = 0.02


def block(x: float, z: float, *half: float) -> Box:
    return Box(RigidTransform([x, 0, z]), np.array(half))


@dc.dataclass(frozen=True)
class Maze:
    """The three-link arm above a block, and a target below it.

    The upper arm passes before the block, which begins 0.66 m from the
    shoulder; the forearm passes only if it is bent. The shoulder cannot go
    round the other way.

    Attributes:
        robot: The arm.
        field: The block.
        q: Where the arm starts, stretched out.
        q_target: Where it ends, stretched out; nothing else reaches X_WT.
        X_WT: The target.
    """

    robot: RobotModel
    field: SignedDistanceField
    q: np.ndarray
    q_target: np.ndarray
    X_WT: np.ndarray

    def planner(self, **settings) -> MotionPlanner:
        return MotionPlanner(self.robot, None, PlanningConfig(**settings))

    def rule(self, **settings) -> SelectionRule:
        config = gain_set("tuned")
        config.collision.stopping = STOPPING
        config.self_collision.enabled = False
        config.guidance.planning = PlanningConfig(**settings)
        law = ReactiveLaw.make(config, self.robot, 0.02)
        return make_selection_rule(
            law,
            config.guidance,
            lambda error: error.distance < 0.01 and error.angle < 0.03,
        )


@pytest.fixture(scope="session")
def maze(three_link) -> Maze:
    q_target = np.array([0.7, 0.0, 0.0])
    return Maze(
        three_link,
        SignedDistanceField(
            PrimitiveScene(boxes=(block(1.01, 1.0, 0.35, 0.5, 0.05),))
        ),
        np.array([-0.7, 0.0, 0.0]),
        q_target,
        three_link.end_effector_pose(q_target),
    )


@pytest.fixture(scope="session")
def empty() -> SignedDistanceField:
    """Nothing at all."""
    return SignedDistanceField(PrimitiveScene())


@pytest.fixture(scope="session")
def board_at():
    """A function (height) -> field of a small board with its top there."""

    def make(height: float) -> SignedDistanceField:
        X_WP = RigidTransform([1.55, -0.25, height - 0.02])
        board = Box(X_WP, np.array([0.25, 0.25, 0.02]))
        return SignedDistanceField(PrimitiveScene(boxes=(board,)))

    return make
