"""Unseen space of a splat's frame, asked in W: all voxels tried, in W."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.oracle.placed_unknown_space import PlacedUnknownSpace
from remosplat_drake.oracle.unknown_space import unknown_space_field
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.coverage import FREE, UNSEEN, Coverage

FLOOR = 0.03
YAW = RigidTransform(RollPitchYaw(0, 0, 0.7), [0.4, -0.2, 0.15])
TILTED = RigidTransform(RollPitchYaw(0.9, -0.4, 2.0), [0.1, 0.3, 0.5])


@pytest.fixture
def coverage() -> Coverage:
    rng = np.random.default_rng(1)
    state = np.where(rng.uniform(size=(12, 10, 11)) < 0.1, UNSEEN, FREE)
    return Coverage(np.full(3, -0.5), 0.1, state.astype(np.uint8))


def spheres_in(coverage: Coverage, X_WG: RigidTransform, **kind) -> Spheres:
    rng = np.random.default_rng(2)
    p_GS = rng.uniform(coverage.lower + 0.05, coverage.upper - 0.05, (200, 3))
    return Spheres.at(X_WG.multiply(p_GS.T).T, **kind)


@pytest.mark.parametrize("X_WG", [YAW, TILTED])
def test_a_pose_changes_no_distance(coverage, X_WG):
    asked = spheres_in(coverage, X_WG)
    answer = PlacedUnknownSpace(coverage, X_WG, FLOOR).clearances(asked)
    p_GS = X_WG.inverse().multiply(asked.p_WS.T).T
    there = unknown_space_field(coverage).clearances(
        dc.replace(asked, p_WS=p_GS)
    )
    np.testing.assert_allclose(answer.distance, there.distance, atol=1e-9)
    # Along its direction a sphere reaches the point that is named.
    p_WC = asked.p_WS[answer.sphere] + (
        answer.distance[:, None] * answer.direction_W
    )
    np.testing.assert_allclose(p_WC, answer.p_WC, atol=1e-9)


@pytest.mark.parametrize("X_WG", [YAW, TILTED])
def test_wheels_ignore_what_is_below_the_floor_of_the_world(coverage, X_WG):
    """Seen is what the grid says, without the voxels with centres below."""
    asked = spheres_in(coverage, X_WG, ignore_below=FLOOR)
    answer = PlacedUnknownSpace(coverage, X_WG, FLOOR).clearances(asked, 0.04)
    index = np.argwhere(coverage.state == UNSEEN)
    p_G = coverage.lower + coverage.voxel * (index + 0.5)
    over = X_WG.multiply(p_G.T)[2] >= FLOOR
    p_GS = X_WG.inverse().multiply(asked.p_WS.T).T
    gap = np.abs(p_GS[:, None] - p_G[over]) - coverage.voxel / 2
    true = np.linalg.norm(np.maximum(gap, 0), axis=2).min(axis=1)
    near = np.zeros(len(asked), bool)
    near[answer.sphere] = True
    # All lie farther than that from the edge of the grid.
    np.testing.assert_array_equal(near, true < 0.04)
    outside = answer.distance > 0
    np.testing.assert_allclose(
        answer.distance[outside], true[answer.sphere[outside]], atol=1e-9
    )


def test_an_undefined_floor_is_refused(coverage):
    field = PlacedUnknownSpace(coverage, TILTED, FLOOR)
    with pytest.raises(ValueError, match=r"ignore_below.*NaN"):
        field.clearances(Spheres.at(np.zeros(3), ignore_below=np.nan))


def test_equal_revisions_answer_equally(coverage):
    fields = [
        PlacedUnknownSpace(coverage, X, FLOOR)
        for X in (RigidTransform(), YAW, TILTED)
    ]
    assert len({field.revision for field in fields}) == 3
    again = PlacedUnknownSpace(coverage, YAW, FLOOR)
    assert again.revision == fields[1].revision


def test_kernels_ask_the_grid_that_is_placed_nowhere_else(coverage):
    here = PlacedUnknownSpace(coverage, RigidTransform(), FLOOR)
    asked = spheres_in(coverage, RigidTransform(), ignore_below=FLOOR)
    grid = unknown_space_field(coverage)
    assert type(here.compiled) is type(grid.compiled)
    assert here.compiled_rows is not None and here.compiled is not None
    assert here.compiled_rows.parts == (here.compiled.values,)
    answer, same = here.clearances(asked), grid.clearances(asked)
    np.testing.assert_array_equal(answer.distance, same.distance)
    np.testing.assert_array_equal(answer.direction_W, same.direction_W)
    there = PlacedUnknownSpace(coverage, YAW, FLOOR)
    assert there.compiled is None and there.compiled_rows is None
