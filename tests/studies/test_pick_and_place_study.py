"""The study of picking and placing: scenarios, judgements, tables."""

import json

import numpy as np
import pytest

from apps.studies.pick_and_place.__main__ import PROBLEMS, fits, main, table_of
from apps.studies.pick_and_place.problem_run import (
    COMPLETE,
    NO_GRASP,
    Outcome,
    forbidden,
)
from apps.studies.pick_and_place.problem_scenario import (
    make_world,
    strong_enough,
)
from remosplat_drake.generation.pick_and_place import (
    SUPPORT,
    TARGET,
    pick_and_place,
)
from remosplat_drake.grasping.gripper import ParallelGripper
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.station.contact_monitor import ContactReport


@pytest.fixture(scope="module")
def gripper():
    return ParallelGripper.of(load_robot("panda"))


@pytest.fixture(scope="module")
def problem(gripper):
    return pick_and_place("table", 0, gripper)


def test_a_problem_becomes_a_scenario_and_its_world(problem, gripper):
    grasps = strong_enough(problem, gripper)
    scenario, world = make_world(problem, gripper.robot, grasps)
    pick, place = scenario.tasks
    assert (pick.object, pick.support) == (TARGET, SUPPORT)
    assert len(pick.grasps) == len(problem.grasps)
    for grasp in pick.grasps:
        assert 10.0 <= grasp.force <= gripper.max_force
    X = problem.X_WO_goal
    assert place.places[0].translation == X.translation().tolist()
    names = [thing.name for thing in world.objects]
    assert names == [*(x.name for x in problem.objects), SUPPORT]
    assert world.objects[-1].mass is None
    # The table is an object, which tasks name: the splat shows the wall alone.
    assert world.splat_W is not None
    assert world.splat_W.p_GK[:, 0].max() < -0.7


@pytest.mark.parametrize(
    ("field", "pair", "bad"),
    [
        ("objects", ("panda_leftfinger", TARGET), False),
        ("objects", ("panda_leftfinger", "thing 1"), True),
        ("objects", ("panda_link5", SUPPORT), True),
        ("others", (SUPPORT, TARGET), False),
        ("others", (TARGET, "wall"), True),
        ("others", (TARGET, "thing 1"), True),
        ("others", (SUPPORT, "thing 1"), False),
        ("scene", ("panda_link0", "floor"), False),
        ("scene", ("panda_hand", "wall"), True),
        ("robot", ("panda_hand", "panda_link1"), True),
    ],
)
def test_only_the_hand_and_the_support_may_touch(field, pair, bad):
    report = ContactReport(**{field: (pair,)})
    assert forbidden(report, {SUPPORT}) == ({pair} if bad else set())


def test_problems_with_a_line_are_not_run_again(tmp_path, capsys):
    outcomes = [
        Outcome("table-0000", "can", 0.3, COMPLETE),
        Outcome("table-0001", "box", 0.4, NO_GRASP),
    ]
    lines = [json.dumps(vars(outcome)) + "\n" for outcome in outcomes]
    (tmp_path / PROBLEMS).write_text("".join(lines))
    flags = ["--families", "table", "--count", "2", "--output", str(tmp_path)]
    assert main(flags) == 0
    printed = capsys.readouterr().out
    assert "1 of 2" in printed
    assert NO_GRASP in printed
    assert (tmp_path / PROBLEMS).read_text() == "".join(lines)


def test_a_table_counts_causes_by_family():
    causes = [COMPLETE, COMPLETE, "time is up", COMPLETE]
    outcomes = [Outcome(f"room-{i}", "", 0, x) for i, x in enumerate(causes)]
    table = table_of(outcomes)
    assert list(table.columns[1].cells) == [COMPLETE, "time is up"]
    assert list(table.columns[2].cells) == ["3 of 4", "1 of 4"]


def test_meshes_that_fit_the_hand_are_counted():
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    angle = np.arange(6) * np.pi / 3
    ring = 0.01 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    needle = np.vstack([ring, [[0, 0, 0.2], [0, 0, -0.2]]])
    hulls = {
        "slim": 0.03 * corners * [0.7, 1, 1],
        "wide": 0.05 * corners,
        "needle": needle,
    }
    assert fits(hulls) == {
        "fits": 1,
        "does not fit the hand": 1,
        "does not stand": 1,
    }
