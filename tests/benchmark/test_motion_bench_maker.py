"""MotionBenchMaker's problems: placed, run, and counted where they are bad."""

import dataclasses as dc
import shutil
from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.benchmark.carrying import load_clearances
from remosplat_drake.benchmark.methods import load_methods
from remosplat_drake.benchmark.motion_bench_maker import (
    START_CLEARANCE,
    motion_problems,
    read_request,
)
from remosplat_drake.benchmark.motion_table import motion_table
from remosplat_drake.benchmark.overview import document
from remosplat_drake.benchmark.report import report_tables
from remosplat_drake.benchmark.result import (
    COLLISION,
    ERROR,
    SUCCESS,
    from_line,
    to_line,
)
from remosplat_drake.benchmark.suites import load_cases
from remosplat_drake.benchmark.summary import gather
from remosplat_drake.benchmark.trial import Trial, run_trial
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.task.carrying import make_payload
from remosplat_drake.task.object_spheres import fit_object

FOLDER = Path(__file__).resolve().parents[1] / "data" / "mbm"
READY = [0, -0.785, 0, -2.356, 0, 1.571, 0.785]


@pytest.fixture
def family(tmp_path) -> Path:
    """A copy of the problem, to be spoilt."""
    shutil.copytree(FOLDER / "shelf_panda", tmp_path / "shelf_panda")
    return tmp_path / "shelf_panda"


def edit(path: Path, before: str, after: str):
    text = path.read_text()
    assert before in text
    path.write_text(text.replace(before, after, 1))


def run_one(problem, method="sdf-reactive-mbm", text=""):
    (loaded,) = load_methods([method], text, None, problem.robot)
    return run_trial(Trial(loaded, problem))


def test_the_panda_stands_where_the_problem_has_it():
    (problem,) = load_cases(f"mbm:{FOLDER}", 20)
    assert (problem.name, problem.family) == ("shelf_0001", "shelf")
    assert problem.suite == "MotionBenchMaker, panda"
    task = problem.task()
    panda = load_robot("panda")
    assert task.arm_start == tuple(READY)
    X_WE = panda.end_effector_pose(np.array([0.8, *READY[1:]]))
    np.testing.assert_allclose(task.X_WE_target.GetAsMatrix4(), X_WE)


def test_what_the_hand_encloses_is_left_out():
    (problem,) = motion_problems(FOLDER, 1)
    truth = problem.truth()
    assert len(truth.boxes) == 1
    (behind,) = truth.cylinders
    assert behind.X_WP.translation()[1] == 0.45


def test_frankie_has_the_same_problem_under_a_displaced_base():
    panda, frankie = (
        motion_problems(FOLDER, 1, robot)[0].task()
        for robot in ("panda", "frankie")
    )
    mount = np.array([0.15, 0, 0.38])
    np.testing.assert_allclose(
        frankie.X_WE_target.translation(),
        panda.X_WE_target.translation() + mount,
        atol=1e-12,
    )
    (board,) = frankie.solids.boxes
    np.testing.assert_allclose(
        board.X_WP.translation(), np.array([0.35, 0.35, 0.38]) + mount
    )
    x, y, yaw = frankie.X_WB_start
    assert -0.3 <= x <= 0.1 and abs(y) <= 0.8 and 0 < abs(yaw) <= 0.6
    robot = load_robot("frankie", "paper", 0.03)
    q = np.array([x, y, yaw, *READY])
    clearance = frankie.truth_field.clearances(robot.spheres_at(q)).minimum()
    assert clearance >= START_CLEARANCE
    assert frankie.arm_goal is None
    # The same each time, another one for another problem.
    again = motion_problems(FOLDER, 1, "frankie")[0]
    assert again.task().X_WB_start == (x, y, yaw)
    other = dc.replace(again, name="shelf_0002")
    assert other.task().X_WB_start != (x, y, yaw)


@pytest.mark.parametrize("robot", ["panda", "frankie"])
def test_it_is_reached_and_tabled(robot):
    (problem,) = motion_problems(FOLDER, 1, robot)
    result = run_one(problem)
    assert result.outcome("text") == SUCCESS
    assert result.text.minimum_distance > 0.015
    assert (result.text.base_path_length > 0) == (robot == "frankie")
    (comparison,) = gather([result])
    table = motion_table(comparison, "text")
    row = dict(zip(table.header, table.rows[-1], strict=True))
    assert row["family"] == "all"
    assert row["reached [%]"].endswith("(1/1)")
    assert "Neither the map nor the true scene" in table.notes
    # The straight way of one joint: 0.8 rad at 2.175 rad/s.
    ratio = row["motion / joint path"]
    if robot == "panda":
        assert result.joint_time == pytest.approx(0.8 / 2.175)
        expected = result.text.duration / result.joint_time
        assert float(ratio) == pytest.approx(expected, abs=0.01)
    else:
        assert ratio == "–"
    assert table in report_tables([result])


def test_collisions_are_judged_by_what_is_left(family):
    blind = "{controller: {collision: {influence: 1e-6, stopping: 0}}}"
    # Can2 stands in the hand's way.
    edit(family / "scene0001.yaml", "[0.3, 0.45, 0.46]", "[0.28, 0.12, 0.5]")
    (problem,) = motion_problems(family, 1)
    assert run_one(problem, "sdf-hard", blind).outcome("text") == COLLISION


@pytest.mark.parametrize(
    ("file", "before", "after", "complaint"),
    [
        ("request0001", "goal_constraints", "goals", "goal_constraints: is m"),
        ("request0001", "joint_constraints", "pose", "joint_constraints: is m"),
        (
            "request0001",
            "panda_joint7, position",
            "x, position",
            "panda_joint7",
        ),
        ("request0001", "position: 0.8", "position: .inf", "finite number"),
        ("request0001", "[0, -0.785,", "[0, -0.785, 0,", "expected 8 numbers"),
        ("scene0001", "type: box", "type: cone", "unknown shape 'cone'"),
        # Bad where only a run can tell.
        ("request0001", "[0, -0.785", "[9, -0.785", "panda_joint1 is beyond"),
        (
            "scene0001",
            "[0.3, 0.45, 0.46]",
            "[0.3, 0, 0.5]",
            "start_state.joint_state.position: the robot would be inside",
        ),
    ],
)
def test_a_bad_problem_is_an_error_in_one_line(
    family, file, before, after, complaint
):
    edit(family / f"{file}.yaml", before, after)
    (problem,) = motion_problems(family, 1)
    result = run_one(problem)
    assert result.outcome("text") == ERROR
    assert complaint in result.problem
    assert str(family) in result.problem
    assert "\n" not in result.problem


def test_half_a_pair_is_counted(family):
    (family / "request0001.yaml").rename(family / "request0002.yaml")
    problems = motion_problems(family, 20)
    assert [p.name for p in problems] == ["shelf_0001", "shelf_0002"]
    results = [run_one(problem) for problem in problems]
    assert [r.outcome("text") for r in results] == [ERROR, ERROR]
    assert "request0001.yaml" in results[0].problem
    assert "scene0002.yaml" in results[1].problem


def test_folders_without_problems_are_refused(tmp_path):
    with pytest.raises(RemoSplatError, match="no such folder"):
        motion_problems(tmp_path / "absent", 1)
    with pytest.raises(RemoSplatError, match=r"contains no requestNNNN\.yaml$"):
        motion_problems(tmp_path, 1)
    (tmp_path / "box_panda.tar.bz2").touch()
    with pytest.raises(RemoSplatError, match=r"box_panda\.tar\.bz2 with `tar"):
        motion_problems(tmp_path, 1)
    with pytest.raises(RemoSplatError, match="unknown robot 'pando'"):
        motion_problems(FOLDER, 1, "pando")


def test_another_robots_request_says_which_joint_it_lacks():
    path = FOLDER / "shelf_panda" / "request0001.yaml"
    with pytest.raises(
        RemoSplatError, match="has no position of joint shoulder_lift"
    ):
        read_request(path, ("shoulder_lift",))


@pytest.mark.shared_data
def test_the_public_problems_can_be_used(shared_data, tmp_path):
    archives = sorted((shared_data / "mbm").glob("*_panda.tar.bz2"))
    for archive in archives:
        shutil.unpack_archive(archive, tmp_path, filter="data")
    problems = motion_problems(tmp_path, 2)
    assert len(problems) == 2 * len(archives)
    panda = load_robot("panda", "paper", 0.03)
    for problem in problems:
        task = problem.task()
        # Without the can the hand fits.
        spheres = panda.spheres_at(np.array(task.arm_goal))
        assert task.truth_field.clearances(spheres).minimum() > 0.0


def test_the_object_to_be_grasped_is_for_the_hand_alone():
    (problem,) = load_cases(f"mbm:{FOLDER}", 1)
    (grasping,) = load_cases(f"mbm-grasp:{FOLDER}", 1)
    assert grasping.suite == "MotionBenchMaker with the object, panda"
    without, task = problem.task(), grasping.task()
    assert task.content_hash != without.content_hash
    robot, truth = load_robot("panda"), without.truth_field
    assert without.with_grasped(truth, robot) is truth
    field = task.with_grasped(task.truth_field, robot)
    spheres = robot.spheres_at(np.array(task.arm_goal))
    n, hand = (
        len(spheres),
        robot.spheres.on_links(
            {"panda_hand", "panda_leftfinger", "panda_rightfinger"}
        ),
    )
    with_it = field.clearances(spheres).per_sphere(n)
    alone = truth.clearances(spheres).per_sphere(n)
    np.testing.assert_array_equal(with_it[hand], alone[hand])
    # Another link there would touch it.
    can = task.grasped[0].X_WO.translation()
    assert field.clearances(Spheres.at(can, 0.01)).minimum() < 0.0


def carrying_problem(folder=FOLDER):
    (problem,) = load_cases(f"mbm-carry:{folder}", 1)
    return problem


def test_the_object_is_carried_back():
    problem = carrying_problem()
    assert problem.suite.endswith("with the object, carried back, panda")
    task = problem.task()
    assert task.content_hash != problem.grasping().task().content_hash
    # The board, whose upper side is where the can stands.
    assert task.support.top == pytest.approx(0.4)
    result = run_one(problem)
    assert result.outcome("text") == SUCCESS
    carrying = result.carrying
    assert (carrying.taken, carrying.outcome) == (True, SUCCESS)
    assert not carrying.reason
    # Up, and back by 0.8 rad at 2.175 rad/s.
    assert carrying.duration > 0.8 / 2.175
    assert carrying.minimum_distance > 0.0
    assert from_line(to_line(result), "here") == result
    tables = report_tables([result])
    (table,) = (t for t in tables if t.title.endswith("carried back"))
    row = dict(zip(table.header, table.rows[-1], strict=True))
    assert row["carried back [%]"].endswith("(1/1)")
    (comparison,) = document([result])["comparisons"]
    assert comparison["methods"][0]["carrying"] == {
        "taken": 1,
        "carried_back": 1,
        "collisions": 0,
    }


def test_the_load_counts_where_it_is(family):
    """The can turns with joint 1, up to where another one stands."""
    edit(family / "scene0001.yaml", "[0.3, 0.45, 0.46]", "[0.0, 0.304, 0.46]")
    task, robot = carrying_problem(family).task(), load_robot("panda")
    q = np.array(task.arm_goal)
    (thing,) = task.grasped
    payload = make_payload(robot, thing, fit_object(thing), q)
    turn = np.zeros(7)
    turn[0] = np.pi / 2 - np.arctan2(0.22, 0.21)
    between, into = q + turn / 2, q + turn
    distances = load_clearances(
        task, robot, np.array([q, between, into]), payload
    )
    # The board on which it stands does not count. The wrist, which turns with
    # it, is the nearest until the other can is.
    assert distances[0] == pytest.approx(distances[1], abs=1e-9)
    assert 0.04 < distances[0] < np.hypot(0.21, 0.304 - 0.22) - 0.06
    # By less than both radii, since the places are 0.1 mm apart.
    assert -0.06 < distances[2] < -0.059
