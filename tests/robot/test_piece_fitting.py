"""Links are cut as finely as their distances need, and no finer.

Worked by hand on the arm of three links: from its upper arm, a bar along x that
reaches 30 mm to all sides, a post hangs down at x from 80 to 140 mm. With the
elbow bent by 2.4 rad the wrist, a ball of 30 mm, is 35 mm beside that post, in
the bend: in the convex hull of the upper arm.
"""

import numpy as np
import pytest
from effort import effort

from remosplat_drake.robot.fitting.convex_pieces import convex_piece
from remosplat_drake.robot.fitting.enclosing_piece import (
    Enclosed,
    enclosing_piece,
)
from remosplat_drake.robot.fitting.enclosure import in_four
from remosplat_drake.robot.fitting.kernels.winding import is_inside
from remosplat_drake.robot.fitting.mesh_truth import MeshTruth, PairError
from remosplat_drake.robot.fitting.piece_fitting import ACCURACY, fit_pieces
from remosplat_drake.robot.fitting.simplified import clustered
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.robot.self_collision.shapes import (
    CollisionShapes,
    ConvexShape,
)
from tests.robot.conftest import THREE_LINK

LINKS = ("upper_arm", "wrist")

BENT = np.array([0.0, 2.4, 0.0])

BESIDE = 0.5 + 0.4 * np.cos(2.4) - 0.03 - 0.14
"""How far the wrist is from the post then [m]."""

BALL = ConvexShape(np.zeros((1, 3)), 0.03)


def box(lower: tuple, upper: tuple) -> np.ndarray:
    x, y, z = zip(lower, upper, strict=True)
    grid = np.stack(np.meshgrid(x, y, z), axis=-1)
    return convex_piece(grid.reshape(-1, 3), 0.0).surface


@pytest.fixture(scope="module")
def upper_arm() -> np.ndarray:
    bar = box((0, -0.03, -0.03), (0.5, 0.03, 0.03))
    post = box((0.08, -0.03, -0.35), (0.14, 0.03, -0.02))
    return np.concatenate([bar, post])


def ball() -> np.ndarray:
    p = np.random.default_rng(5).standard_normal((2000, 3))
    p *= 0.03 / np.linalg.norm(p, axis=1, keepdims=True)
    return convex_piece(p, 0.0).surface


def truth_in(states: np.ndarray, upper_arm: np.ndarray) -> MeshTruth:
    surfaces = {"upper_arm": upper_arm, "wrist": ball()}
    return MeshTruth(load_robot(THREE_LINK), surfaces, states)


@pytest.fixture(scope="module")
def truth(upper_arm) -> MeshTruth:
    rng = np.random.default_rng(5)
    drawn = rng.uniform([-2, -2.5, -3], [2, 2.5, 3], (50, 3))
    return truth_in(np.vstack([BENT, drawn]), upper_arm)


def worst_errors(
    truth: MeshTruth, shapes: CollisionShapes, least: float
) -> tuple[PairError, ...]:
    return truth.errors(shapes, {LINKS: None}, least)[LINKS].worst


def test_a_hull_over_a_bend_is_wrong_by_what_it_bridges(upper_arm):
    hull = enclosing_piece(upper_arm)
    truth = truth_in(BENT[None], upper_arm)
    shapes = CollisionShapes(LINKS, (ConvexShape(hull.vertices), BALL))
    error = worst_errors(truth, shapes, ACCURACY)[0]
    assert error.shapes == (0, 1)
    # The nearest samples of two surfaces are a little farther apart.
    assert error.distance == pytest.approx(BESIDE, abs=1e-3)
    # The wrist is in the hull, and the middle of the air is far from both bars.
    assert error.error > BESIDE + 0.03
    assert error.blame[0] > 0.02 > error.blame[1]


def test_true_shapes_have_no_error(upper_arm, truth):
    bar, post = upper_arm[:12], upper_arm[12:]
    corners = [part.reshape(-1, 3) for part in (bar, post)]
    shapes = CollisionShapes(
        ("upper_arm", *LINKS), (*map(ConvexShape, corners), BALL)
    )
    assert not truth.errors(shapes, {LINKS: None}, 2e-3)


def test_postures_in_which_meshes_cut_each_other_hide_no_other(upper_arm):
    """Pieces overlap by more in these, in which nothing is wrong."""
    elbow = np.linspace(2.95, 3.1, 100)
    cutting = np.column_stack([0 * elbow, elbow, 0 * elbow])
    truth = truth_in(np.vstack([cutting, BENT]), upper_arm)
    hull = enclosing_piece(upper_arm)
    shapes = CollisionShapes(LINKS, (ConvexShape(hull.vertices), BALL))
    (error,) = worst_errors(truth, shapes, ACCURACY)
    assert error.distance == pytest.approx(BESIDE, abs=1e-3)


def test_the_largest_errors_are_found_although_few_are_measured(upper_arm):
    elbow = np.linspace(2.3, 2.5, effort(16, 40))
    states = np.column_stack([0 * elbow, elbow, 0 * elbow])
    hull = enclosing_piece(upper_arm)
    shapes = CollisionShapes(LINKS, (ConvexShape(hull.vertices), BALL))
    alone = []
    for state in states:
        truth = truth_in(state[None], upper_arm)
        found = truth.errors(shapes, {LINKS: None}, 1e-3)
        alone += [found[LINKS].worst[0].error] if found else []
    found = truth_in(states, upper_arm).errors(shapes, {LINKS: None}, 1e-3)
    worst = [error.error for error in found[LINKS].worst]
    assert len(alone) > len(worst)
    np.testing.assert_allclose(worst, sorted(alone)[: -len(worst) - 1 : -1])
    # None of the others is ruled out.
    assert len(found[LINKS].postures) >= len(alone)


def test_worse_postures_are_found_from_a_bad_one(upper_arm):
    """The wrist is at the edge of the bend, and can go farther into it."""
    edge = np.array([[0.0, 2.36, 0.0]])
    truth = truth_in(edge, upper_arm)
    hull = enclosing_piece(upper_arm)
    shapes = CollisionShapes(LINKS, (ConvexShape(hull.vertices), BALL))
    (before,) = worst_errors(truth, shapes, 0.0)
    assert truth.add_worst(shapes, [LINKS], before.error) == [LINKS]
    after = worst_errors(truth, shapes, 0.0)[0]
    assert after.error > before.error + 5e-3
    # The shoulder does not move one against the other.
    np.testing.assert_array_equal(truth.states[:, 0], 0.0)
    assert len(truth.states) > 1


def test_only_what_is_wrong_is_cut(upper_arm, truth):
    """Nothing comes near the forearm, whose bend stays filled."""
    mesh = Enclosed.make(upper_arm)
    meshes = {"upper_arm": [mesh], "forearm": [mesh]}
    primitives = CollisionShapes(("wrist",), (BALL,))
    fitted = fit_pieces(meshes, primitives, truth)
    assert not fitted.errors
    assert len(fitted.pieces["upper_arm"]) >= 2
    assert len(fitted.pieces["forearm"]) == 1


def shell_around_wrist(is_open: str) -> np.ndarray:
    """A box around the bent arm's wrist, 20 mm from it along x, 4 mm thick.

    It stands on the mount. The forearm, which is 10 mm thick, meets the box in
    the middle of its side at the greater x.
    """
    x, z = 0.5 + 0.4 * np.cos(2.4), 1.0 - 0.4 * np.sin(2.4)
    inner, outer = np.array([0.05, 0.06, 0.08]), np.array([0.054, 0.064, 0.084])
    walls = []
    for axis in range(3):
        for sign in (-1, 1):
            if f"{'-+'[sign > 0]}{'xyz'[axis]}" == is_open:
                continue
            lower, upper = -outer, outer.copy()
            side = sorted((sign * inner[axis], sign * outer[axis]))
            lower[axis], upper[axis] = side
            at = np.array([x, 0.0, z])
            walls.append(box(tuple(at + lower), tuple(at + upper)))
    return np.concatenate(walls)


@pytest.mark.parametrize("is_open", ["", "-x", "-z", "+x"])
def test_a_hollow_counts_only_if_the_arm_can_reach_into_it(is_open):
    """Unless the side is open at which the forearm enters, it cuts a wall."""
    shell = shell_around_wrist(is_open)
    forearm = box((0.0, -0.005, -0.005), (0.4, 0.005, 0.005))
    surfaces = {"mount": shell, "forearm": forearm, "wrist": ball()}
    # The robot's other postures keep the forearm out of the walls.
    states = np.vstack([BENT, np.zeros((3, 3))])
    truth = MeshTruth(load_robot(THREE_LINK), surfaces, states)
    hull = ConvexShape(enclosing_piece(shell).vertices)
    links = ("mount", "wrist")
    shapes = CollisionShapes(links, (hull, BALL))
    found = truth.errors(shapes, {links: None}, ACCURACY)
    primitives = CollisionShapes(("wrist",), (BALL,))
    meshes = {"mount": [Enclosed.make(shell)]}
    fitted = fit_pieces(meshes, primitives, truth)
    if is_open != "+x":
        assert not found
        assert len(fitted.pieces["mount"]) == 1
        return
    error = found[links].worst[0]
    assert error.distance == pytest.approx(0.02, abs=1e-3)
    assert error.error > 0.02 + 0.05
    # Four cuts would free the wrist, but none of them does so alone.
    assert [error.links for error in fitted.errors] == [links]


def test_what_cannot_be_mended_is_named(truth):
    """A box that has come from elsewhere cannot be cut truer than it is."""
    wrong = box((0, -0.03, -0.36), (0.3, 0.03, 0.03))
    fitted = fit_pieces(
        {"upper_arm": [Enclosed.make(wrong)]},
        CollisionShapes(("wrist",), (BALL,)),
        truth,
    )
    (error,) = fitted.errors
    assert error.links == LINKS
    assert error.error > ACCURACY


def test_a_point_in_a_box_is_inside():
    surface = box((0, 0, 0), (1, 2, 3))
    assert is_inside(np.array([0.5, 1.0, 0.1]), surface)
    assert not is_inside(np.array([0.5, 1.0, -0.1]), surface)
    # Coarser, too.
    cut = surface
    for _ in range(4):
        cut = in_four(cut)
    coarse = clustered(cut, 0.4)
    assert len(coarse) < len(cut) / 10
    assert is_inside(np.array([0.5, 1.0, 0.8]), coarse)
    assert not is_inside(np.array([0.5, 1.0, -0.8]), coarse)
    # Without one side of it, too.
    assert is_inside(np.array([0.5, 1.0, 1.5]), surface[2:])
