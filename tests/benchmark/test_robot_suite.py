"""Random targets of robots: goals that can be held, and how they are told."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.benchmark import robot_suite
from remosplat_drake.benchmark.metrics import self_distance, target_errors
from remosplat_drake.benchmark.report import report_tables
from remosplat_drake.benchmark.result import Judgement, TrialResult
from remosplat_drake.benchmark.robot_suite import GENERATED, robot_cases
from remosplat_drake.benchmark.suites import suite_robots
from remosplat_drake.benchmark.trial import start_problem
from remosplat_drake.generation.furniture import furniture
from remosplat_drake.robot.robot_description import shipped_robots
from remosplat_drake.robot.robot_model import load_robot


@pytest.mark.parametrize("name", ["ur5e", "ridgeback_panda"])
def test_goals_can_be_held(name):
    cases = robot_cases([name], 2)
    assert [case.scene for case in cases] == 2 * [GENERATED] + 2 * [
        "workbench" if name == "ur5e" else "table"
    ]
    robot = load_robot(name, floor_height=robot_suite.FLOOR_HEIGHT)
    for case in cases:
        task = case.task()
        q = np.array(case.goal)
        np.testing.assert_allclose(
            robot.end_effector_pose(q), task.X_WE_target.GetAsMatrix4()
        )
        clearance = task.truth_field.clearances(robot.spheres_at(q)).minimum()
        assert clearance > 0.029
        assert (q > robot.position_lower).all()
        assert (q < robot.position_upper).all()
        assert self_distance(robot, q[None]) > 0.0
        base = task.X_WB_start if robot.n_base else ()
        start = np.array([*base, *robot.home])
        assert not start_problem(robot, start, task.truth_field)
    assert len({case.task().content_hash for case in cases}) == 2
    targets = [case.task().X_WE_target.GetAsMatrix4() for case in cases]
    assert np.abs(targets[0] - targets[1]).max() > 0.05
    # They do not depend on what was drawn before.
    again = robot_cases([name], 2)[1].task().X_WE_target.GetAsMatrix4()
    np.testing.assert_array_equal(again, targets[1])


def test_two_hands_have_a_target_each():
    (case,) = robot_cases(["two_pandas"], 1)[:1]
    task, robot = case.task(), load_robot("two_pandas")
    q = np.array(case.goal)
    X_WEs = robot.end_effector_poses(q)
    np.testing.assert_allclose(task.X_WTs, X_WEs)
    assert not np.allclose(X_WEs[0], X_WEs[1])
    # Both have to arrive: the error is that of the one that has not.
    home = robot.q_home
    home[:7] = q[:7]
    errors = target_errors(robot, np.array([q, home]), task.X_WTs)
    assert errors[0].distance < 1e-9
    right = X_WEs[1, :3, 3] - robot.end_effector_pose(home, 1)[:3, 3]
    assert errors[1].distance == pytest.approx(np.linalg.norm(right))


def test_hands_are_inside_furniture():
    cases = robot_cases(["panda"], 1, "shelf,under_table")
    assert [case.scene for case in cases] == ["shelf", "under_table"]
    robot = load_robot("panda", floor_height=robot_suite.FLOOR_HEIGHT)
    for case in cases:
        task, q = case.task(), np.array(case.goal)
        drawn = furniture(robot, case.scene, case.piece)
        assert drawn.holds(task.X_WE_target.translation())
        assert task.content_hash == drawn.scene.content_hash
        clearance = task.truth_field.clearances(robot.spheres_at(q)).minimum()
        assert clearance > 0.029
        assert not start_problem(robot, robot.home, task.truth_field)


@pytest.mark.slow
def test_processes_draw_the_same_targets():
    told = []
    together = robot_cases(
        ["panda"], 2, "shelf", 2, lambda *drawn: told.append(drawn)
    )
    assert together == robot_cases(["panda"], 2, "shelf")
    assert told == [("targets", 1, 2), ("targets", 2, 2)]


def test_an_unknown_scene_is_refused():
    with pytest.raises(RemoSplatError, match="robots:shelve: unknown scene"):
        robot_cases(["panda"], 1, "shelve")


def test_generated_scenes_leave_the_robot_free():
    for name in shipped_robots():
        scene = robot_suite._scene(name, GENERATED, 0)
        assert len(scene) == 8
        assert scene.name == f"clutter-{name}-0000"


def test_the_suite_drives_what_is_shipped_or_asked_for():
    assert suite_robots("robots") == shipped_robots()
    assert suite_robots("robots", "ur5e,a/b.yaml") == ["ur5e", "a/b.yaml"]
    assert suite_robots("generated") == [""]
    assert suite_robots("mbm:folder") == ["panda"]
    with pytest.raises(RemoSplatError, match="permits only one robot"):
        suite_robots("generated", "ur5e,panda")


def test_self_distance_sees_an_overlap(frankie):
    q = frankie.q_home
    apart = self_distance(frankie, q[None])
    assert apart > 0.0
    q[3:] = 0, 1.7, 0, -0.1, 0, 0.1, 0  # Down through the base.
    assert self_distance(frankie, np.stack([frankie.q_home, q])) < 0.0


def test_a_row_for_each_robot_and_scene():
    judged = Judgement("success", 3.0, 0.1, 0.02, 1.0, 1.0, 1.0, 0.5)
    first = TrialResult(
        key="a",
        method="robots-guided",
        scene="ur5e_clutter_0000",
        family="ur5e, clutter",
        spheres="covering",
        gains="tuned",
        oracle="SphereToEllipsoid",
        splat="surfel",
        splat_count=10,
        station="kinematic",
        seed=0,
        version="1",
        suite=robot_suite.SUITE,
        text=judged,
        authors=judged,
        self_distance=0.012,
    )
    hit = dc.replace(
        first,
        key="b",
        scene="fetch_table_0000",
        family="fetch, table",
        text=dc.replace(judged, outcome="collision", minimum_distance=-0.001),
        self_distance=-0.002,
    )
    table, outcomes = report_tables([first, hit])
    rows = {row[1]: row for row in table.rows}
    assert rows["ur5e, clutter"][2].endswith("(1/1)")
    assert rows["ur5e, clutter"][4:6] == ("20.0", "12.0")
    assert rows["fetch, table"][2].endswith("(0/1)")
    assert rows["fetch, table"][3].startswith("1/1")
    assert rows["fetch, table"][5] == "-2.0"
    assert len(outcomes.rows) == 1
