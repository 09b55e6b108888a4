"""Problems of picking and placing: seeded, and free of contact."""

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.generation.pick_and_place import (
    FAMILIES,
    LEAST_GAP,
    footprint,
    pick_and_place,
    points_near,
)
from remosplat_drake.grasping.grasps import ENOUGH
from remosplat_drake.grasping.gripper import ParallelGripper
from remosplat_drake.grasping.kernels.hand_clearance import hand_clearances
from remosplat_drake.robot.robot_model import load_robot


@pytest.fixture(scope="module")
def grippers() -> dict[str, ParallelGripper]:
    return {
        name: ParallelGripper.of(load_robot(name))
        for name in ("panda", "frankie")
    }


@pytest.fixture(scope="module")
def table(grippers):
    return pick_and_place("table", 1, grippers["panda"])


@pytest.fixture(scope="module", params=list(FAMILIES))
def problem(request, grippers, table):
    if request.param == "table":
        return table
    robot, _ = FAMILIES[request.param]
    return pick_and_place(request.param, 1, grippers[robot])


def test_objects_stand_apart_on_their_support(problem):
    supports = {box.name: box.top for box in problem.scene.boxes}
    height = supports[problem.pick.support]
    assert height == pytest.approx(problem.pick.lower[2])
    plan = []
    for thing in problem.objects:
        p_WO = thing.X_WO.translation()
        assert p_WO[2] + thing.corners[0, 2] == pytest.approx(height)
        plan.append((p_WO[:2], footprint(thing.solid)))
    target = problem.objects[0]
    plan.append((problem.X_WO_goal.translation()[:2], footprint(target.solid)))
    goal_height = supports[problem.place.support]
    foot = problem.X_WO_goal.translation()[2] + target.corners[0, 2]
    assert foot == pytest.approx(goal_height)
    for i, (p, r) in enumerate(plan):
        for q, s in plan[:i]:
            shelved = problem.place is not problem.pick and i == len(plan) - 1
            assert shelved or np.linalg.norm(p - q) > r + s + LEAST_GAP


def test_grasps_suit_both_places(problem, grippers):
    gripper = grippers[problem.robot]
    assert 0 < len(problem.grasps) <= 12
    solids = [
        *problem.scene.primitives,
        *(thing.solid for thing in problem.objects[1:]),
    ]
    for X_WO in (problem.objects[0].X_WO, problem.X_WO_goal):
        points = points_near(solids, X_WO)
        assert len(points)
        for grasp in problem.grasps:
            pieces = gripper.pieces(grasp.opening)
            poses = grasp.X_OE[None]
            assert hand_clearances(*pieces, poses, points, ENOUGH)[0] > 0.005


def test_a_seed_gives_one_problem(grippers, table):
    first, gripper = table, grippers["panda"]
    again = pick_and_place("table", 1, gripper)
    other = pick_and_place("table", 2, gripper)
    assert first.name == "table-0001"
    for a, b in zip(first.objects, again.objects, strict=True):
        assert (a.name, a.mass) == (b.name, b.mass)
        assert a.X_WO.IsExactlyEqualTo(b.X_WO)
    assert first.X_WO_goal.IsExactlyEqualTo(again.X_WO_goal)
    np.testing.assert_array_equal(first.grasps[0].X_OE, again.grasps[0].X_OE)
    assert not first.X_WO_goal.IsNearlyEqualTo(other.X_WO_goal, 1e-3)


def test_an_unknown_family_is_named(grippers):
    with pytest.raises(RemoSplatError, match="family"):
        pick_and_place("tabel", 0, grippers["panda"])
