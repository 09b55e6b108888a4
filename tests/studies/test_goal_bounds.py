"""Goals that can be held: hand-made scenes, cache and table."""

import dataclasses as dc
from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform

from apps.studies import goal_bounds as study
from apps.studies.goal_bounds import (
    GoalVerdict,
    goal_bounds,
    goal_table,
    largest_held,
    read_verdicts,
)
from remosplat_drake.base.errors import FileError
from remosplat_drake.benchmark.scene_case import SceneCase
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi


def slab_below_target(gap: float) -> PrimitiveScene:
    """A slab whose top is so far below the hand's lowest sphere."""
    scene = generate("table", 0)
    assert scene.X_WE_target is not None
    robot = load_robot("frankie", "paper")
    q = np.zeros(robot.n_q)
    X_WE = robot.end_effector_pose(q)
    hand = robot.spheres_at(q).select(robot.leading_spheres)
    p_ES = (hand.p_WS - X_WE[:3, 3]) @ X_WE[:3, :3]
    X_WT = scene.X_WE_target
    p_WS = p_ES @ X_WT.rotation().matrix().T + X_WT.translation()
    top = (p_WS[:, 2] - hand.radius).min() - gap
    center = [*X_WT.translation()[:2], top - 0.05]
    slab = Box(RigidTransform(center), np.array([0.15, 0.15, 0.05]))
    return dc.replace(scene, boxes=(slab,), cylinders=())


@pytest.mark.parametrize(
    ("gap", "expected"), [(0.05, 0.021), (0.0, 0.010), (-0.2, None)]
)
def test_the_largest_clearance_that_the_goal_allows(gap, expected):
    # At the target itself the gap is the clearance; the tolerance there is
    # 20 mm, and turning the hand gains nothing on one side without loss on
    # the other.
    robot = load_robot("frankie", "paper", 0.03)
    assert largest_held(robot, slab_below_target(gap)) == expected


@pytest.fixture
def cases(tmp_path) -> list[SceneCase]:
    found = []
    for name, gap in (("open", 0.05), ("closed", -0.2)):
        file = tmp_path / f"{name}.json"
        write_rmmi(file, slab_below_target(gap))
        found.append(SceneCase(name, "table", "toys", str(file)))
    return found


def test_verdicts_are_kept_and_counted(cases, tmp_path, monkeypatch):
    path = tmp_path / "goals.jsonl"
    told: list[tuple[int, int]] = []
    verdicts = goal_bounds(cases, path, 0, lambda *n: told.append(n))
    assert told[-1] == (4, 4)
    assert {(v.scene, v.spheres) for v in verdicts} == {
        (name, spheres)
        for name in ("open", "closed")
        for spheres in ("paper", "covering")
    }
    assert {v.held for v in verdicts if v.scene == "closed"} == {None}
    assert read_verdicts(path) == verdicts

    monkeypatch.setattr(study, "judge", None)  # Nothing is asked again.
    assert goal_bounds(cases, path, 0) == verdicts
    table = goal_table(verdicts)
    assert table is not None
    paper = [row for row in table.rows if row[1] == "paper"]
    assert [row[2] for row in paper] == ["21", "10"]
    assert all("(1/2)" in row[3] for row in paper)


def test_without_verdicts_there_is_no_table():
    assert goal_table([]) is None
    failed = GoalVerdict("k", "toys", "table", "x", "paper", error="broken")
    assert goal_table([failed]) is None


def test_a_smaller_clearance_counts_where_the_larger_is_held():
    def verdict(held: float | None) -> GoalVerdict:
        return GoalVerdict("k", "toys", "table", "x", "paper", held)

    table = goal_table([verdict(0.021), verdict(0.010), verdict(None)])
    assert table is not None
    assert ["(1/3)" in table.rows[0][3], "(2/3)" in table.rows[1][3]] == [
        True
    ] * 2


def test_a_foreign_file_is_refused(tmp_path):
    path: Path = tmp_path / "goals.jsonl"
    path.write_text('{"method": "sdf"}\n')
    with pytest.raises(FileError, match="verdicts about goals"):
        read_verdicts(path)
