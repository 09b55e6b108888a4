"""The feasibility filter: goals in the open, in solids and in between."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.generation import feasible_scenes
from remosplat_drake.generation.feasibility import (
    FeasibilityFilter,
    _GoalSearch,
    goal_configuration,
    hand_fits,
    passes,
)
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

CRITERIA = FeasibilityFilter(restarts=20)


def box(center, half_extents) -> Box:
    return Box(RigidTransform(np.array(center)), np.array(half_extents))


def around_target(*boxes: Box) -> PrimitiveScene:
    """The table family's task among other things."""
    scene = generate("table", 0)
    return dc.replace(scene, boxes=boxes, cylinders=())


def test_a_goal_in_the_open_is_reached(frankie):
    scene = around_target(box([1.5, 0, 0.3], [0.5, 0.5, 0.03]))
    q = goal_configuration(frankie, scene, CRITERIA)
    assert q is not None
    X_WT = scene.X_WE_target.GetAsMatrix4()
    error = pose_error(frankie.end_effector_pose(q), X_WT)
    assert error.distance < 0.02
    assert error.angle < np.radians(2)
    field = SignedDistanceField(scene)
    clearance = field.clearances(frankie.spheres_at(q)).minimum()
    assert clearance >= CRITERIA.clearance
    assert (q >= frankie.position_lower).all()
    assert (q <= frankie.position_upper).all()
    assert passes(frankie, scene, CRITERIA)


def test_a_hand_inside_a_solid_cannot_fit(frankie):
    p = np.array(generate("table", 0).X_WE_target.translation())
    inside = around_target(box(p + np.array([0, 0, 0.1]), [0.1, 0.1, 0.05]))
    assert not hand_fits(frankie, inside, CRITERIA)
    assert not passes(frankie, inside, CRITERIA)


def test_a_wall_behind_the_wrist_is_no_goal(frankie):
    """The hand fits under a low ceiling, the wrist above it does not."""
    p = np.array(generate("table", 0).X_WE_target.translation())
    slab = around_target(box(p + np.array([0, 0, 0.33]), [3, 3, 0.02]))
    few = dc.replace(CRITERIA, restarts=3)
    assert goal_configuration(frankie, slab, few) is None


def test_a_start_beside_an_obstacle_does_not_count(frankie):
    scene = around_target(box([0.65, 0, 0.2], [0.2, 0.2, 0.2]))
    assert not passes(frankie, scene, CRITERIA)


def test_the_filter_is_repeatable(frankie, table_scene):
    q = goal_configuration(frankie, table_scene, CRITERIA)
    assert q is not None
    np.testing.assert_array_equal(
        q, goal_configuration(frankie, table_scene, CRITERIA)
    )


def test_the_jacobian_is_that_of_the_residuals(frankie, table_scene):
    search = _GoalSearch(
        frankie,
        SignedDistanceField(table_scene),
        table_scene.X_WE_target.GetAsMatrix4(),
        0.0,
        CRITERIA,
    )
    rng = np.random.default_rng(1)
    for _ in range(3):
        q = search.guess(rng) + rng.normal(0, 0.05, frankie.n_q)
        steps = 1e-6 * np.eye(frankie.n_q)
        numeric = [
            (search.residuals(q + h) - search.residuals(q - h)) / 2e-6
            for h in steps
        ]
        np.testing.assert_allclose(
            search.jacobian(q), np.transpose(numeric), atol=1e-5
        )


def test_a_scene_without_a_target_is_refused(frankie):
    with pytest.raises(RemoSplatError, match="needs a target"):
        goal_configuration(frankie, PrimitiveScene(name="bare"), CRITERIA)


def test_decisions_are_kept(tmp_path, monkeypatch):
    asked = []

    def only_even(robot, scene, criteria):
        asked.append(scene.name)
        return int(scene.name[-1]) % 2 == 0

    monkeypatch.setattr(feasible_scenes, "passes", only_even)

    def seeds(count: int) -> list[int]:
        return feasible_scenes.feasible_seeds(
            "table", count, CRITERIA, tmp_path
        )

    assert seeds(2) == [0, 2]
    assert seeds(3) == [0, 2, 4]
    assert seeds(1) == [0]
    assert len(asked) == 5
    (file,) = tmp_path.iterdir()
    file.write_text("damaged")
    assert seeds(1) == [0]
    assert len(asked) == 6


@pytest.mark.slow
def test_processes_decide_as_one_does(tmp_path):
    """The seeds do not depend on which scene is decided on first."""
    found = []
    alone = feasible_scenes.feasible_seeds("table", 3, CRITERIA, tmp_path / "a")
    together = feasible_scenes.feasible_seeds(
        "table", 3, CRITERIA, tmp_path / "b", jobs=2, on_found=found.append
    )
    assert together == alone
    assert found == sorted(found)
    assert found[-1] == 3
