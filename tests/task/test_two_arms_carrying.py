"""One arm carries, the other comes near: what it may touch, and what not.

From any start, and for any targets: the carried object keeps its distance from
all links but its holders, by the collision shapes of the robot.
"""

import dataclasses as dc

import numpy as np
import pytest
from carried import can_at, can_in_hand
from effort import effort
from pydrake.math import RigidTransform, RollPitchYaw
from true_shapes import Moment, near_bodies

from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target
from remosplat_drake.task.task import TaskState

DT, OWN, ROUNDING = 0.05, 0.01, 1e-5
FAR = SignedDistanceField(
    PrimitiveScene(boxes=(Box(RigidTransform([9.0, 9, 9]), np.full(3, 0.1)),))
)


def near(X_WE, rng):
    """A target near a pose, turned somehow."""
    turn = RollPitchYaw(rng.uniform(-0.3, 0.3, 3))
    X = RigidTransform(turn, rng.uniform(-0.02, 0.02, 3)).GetAsMatrix4()
    return Target(X_WE @ X)


def drive(robot, payload, rng, ticks):
    """The configurations of a run in which the right hand goes for the can.

    The left one brings it to the middle, and holds it by its upper end.
    """
    law = ReactiveLaw.make(gain_set("tuned"), robot, DT).holding(payload)
    q, u, found = robot.q_home, np.zeros(robot.n_u), []
    middle = robot.end_effector_pose(q)
    middle[:2, 3] = 0.45, 0.05
    beside = np.eye(4)
    # To the left, its fingers close along x.
    beside[:3, :3] = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
    beside[:3, 3] = middle[:3, 3] - [0.0, 0.0, 0.05]
    left, right = near(middle, rng), near(beside, rng)
    for k in range(ticks):
        spheres = law.robot.spheres_at(q)
        rows = FAR.clearances(spheres, law.collision.influence)
        aim = Aim((left, right))
        u = run_tick(law, k * DT, q, aim, rows, FAR, u).command
        q = robot.advance(q, u, DT)
        found.append(q)
    return found


def least(robot, qs, payload):
    """By link, the least distance of the can from those that do not hold it."""
    can = can_at(robot.end_effector_pose(robot.q_home))
    state = TaskState((can,), payload=payload)
    moments = [Moment(q, state) for q in qs]
    pairs = near_bodies(moments, robot, 0.05)
    return {
        next(name for name in pair if name != "load"): distance
        for pair, distance in pairs.items()
        if "load" in pair
    }


def check(robot, seed, drives, ticks):
    """Drives with and without leave to touch; the least distance without."""
    rng = np.random.default_rng(seed)
    mine = can_in_hand(robot, robot.q_home)
    right = hand_links(robot, 1)
    both = dc.replace(mine, holders=mine.holders | right)
    nearest, entered = np.inf, 0
    for _ in range(drives):
        drawn = rng.integers(1 << 30)
        for payload in (mine, both):
            again = np.random.default_rng(drawn)
            qs = drive(robot, payload, again, ticks)
            distances = least(robot, qs, payload)
            assert all(d > OWN - ROUNDING for d in distances.values())
            nearest = min([nearest, *distances.values()])
        # With leave to touch it, the right hand goes into it.
        into = least(robot, qs, mine)
        entered += any(into.get(link, 1.0) < 0.0 for link in right)
    return nearest, entered


def test_what_is_carried_keeps_off_all_but_its_holders(two_pandas):
    nearest, entered = check(two_pandas, 0, drives=3, ticks=60)
    # They came as near as they may, or this would be idle.
    assert nearest < OWN + 0.006 and entered > 0


@pytest.mark.slow
def test_it_keeps_off_in_many_drives(two_pandas):
    nearest, entered = check(two_pandas, 1, drives=effort(20, 250), ticks=200)
    assert nearest < OWN + 0.006 and entered > 5
