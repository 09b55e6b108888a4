"""The study of true maps: its meshes, its cameras, its judge, its counting."""

import dataclasses as dc
import json
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RollPitchYaw
from scipy.spatial.transform import Rotation

from apps.studies.attacks import Aim, Attack, Attacks
from apps.studies.map_bound.judge import FARTHEST, NEAREST
from apps.studies.rigid_motion import CameraErrors
from apps.studies.true_maps import report, rods
from apps.studies.true_maps.__main__ import THIN, cases, main, thin_cases
from apps.studies.true_maps.cameras import (
    HEIGHT,
    WIDTH,
    Cameras,
    pinhole,
)
from apps.studies.true_maps.case import CLEARANCE, Case, Taken, draw_case
from apps.studies.true_maps.closed_loop import (
    MeshTruth,
    attack_case,
    find_places,
)
from apps.studies.true_maps.disturbance import EXACT, NAMED, Disturbance
from apps.studies.true_maps.disturbed import (
    disturbed,
    true_cameras,
    with_flying_pixels,
)
from apps.studies.true_maps.judge import (
    Excess,
    judge,
    laid_on_truth,
    random_queries,
)
from apps.studies.true_maps.meshes.mesh import Mesh, box, curve, tube, upright
from apps.studies.true_maps.ray_casting import RayCaster
from apps.studies.true_maps.scene import (
    COLORS,
    KINDS,
    MeshScene,
    Part,
    draw_scene,
)
from apps.studies.true_maps.sight import Sight
from apps.studies.true_maps.tracking import velocity_W
from apps.studies.true_maps.trial import Result, restored, run_trial
from apps.studies.true_maps.walk import RATE, Walk
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.surfels.surfels import (
    Surfels,
    splat_of_surfels,
)
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.splat.gaussian_splat import GaussianSplat

pytestmark = pytest.mark.usefixtures("open3d")

TOP = 0.7
"""Height of the board that is judged [m]."""


def ball(radius: float) -> Mesh:
    angle = np.linspace(-np.pi / 2, np.pi / 2, 65)[1:-1]
    return upright(radius * np.sin(angle), radius * np.cos(angle), 128)


def caster(*meshes: Mesh) -> RayCaster:
    parts = tuple(Part("rod", mesh) for mesh in meshes)
    return RayCaster(MeshScene(parts, np.zeros(3)))


def walk(scene: MeshScene) -> Walk:
    """A walk in 2 s over 60 degrees, 1 m away."""
    still = np.zeros(3)
    swing = np.array([np.deg2rad(30), 0.25, -np.pi / 2])
    return Walk(
        scene.focus_W,
        np.array([0.0, 1.0, 0.5]),
        np.array([[swing], [still], [still]]),
        np.zeros((4, 1, 3)),
    )


def taken(scene: MeshScene, what: Disturbance = EXACT) -> Taken:
    rays, time = RayCaster(scene), np.arange(20) / RATE
    cameras = true_cameras(walk(scene), time, what, 0)
    return Taken(scene, rays, cameras, disturbed(rays, cameras, what, 0))


def board() -> MeshScene:
    mesh = box([-0.5, -0.5, TOP - 0.05], [0.5, 0.5, TOP])
    return MeshScene((Part("table", mesh),), np.array([0, 0, TOP + 0.1]))


@cache
def board_taken() -> Taken:
    """Exact images of the board, which tests only read."""
    return taken(board())


@cache
def board_sight() -> Sight:
    return Sight(board_taken())


def splat_of_board(sunk: float = 0.0) -> GaussianSplat:
    """Discs on all sides of the board but its lower one, perhaps too low."""
    middle = np.arange(-0.495, 0.5, 0.01)
    u, v = (grid.ravel() for grid in np.meshgrid(middle, middle))
    edge, z = (
        g.ravel() for g in np.meshgrid(middle, TOP - 0.005 * np.arange(11))
    )
    p_W = [np.stack([u, v, np.full(u.shape, TOP)], axis=1)]
    normal_W = [np.tile([0, 0, 1.0], (len(u), 1))]
    for turn in np.pi / 2 * np.arange(4):
        R = Rotation.from_rotvec([0, 0, turn])
        p_W.append(R.apply(np.stack([np.full(z.shape, 0.5), edge, z], axis=1)))
        normal_W.append(np.tile(R.apply([1.0, 0, 0]), (len(z), 1)))
    p_WK, n_W = np.concatenate(p_W), np.concatenate(normal_W)
    p_WK = p_WK - [0, 0, sunk]
    color = np.full_like(p_WK, 0.5)
    surfels = Surfels(p_WK, n_W, color, np.full(len(p_WK), 0.01))
    return splat_of_surfels(surfels)


def test_a_ball_is_hit_and_near_where_its_formula_says():
    rays = caster(ball(0.2))
    rng = np.random.default_rng(0)
    p_W = rng.uniform(-1, 1, (300, 3))
    near, away = rays.nearest(p_W), np.linalg.norm(p_W, axis=1)
    # 128 corners around 0.2 m lie 0.06 mm outside of their sides.
    np.testing.assert_allclose(near.distance, abs(away - 0.2), atol=5e-4)
    np.testing.assert_allclose(
        abs((near.normal_W * p_W).sum(axis=1)), away, rtol=0.01
    )
    hits = rays.cast(np.array([1.0, 0, 0]), np.array([[-0.5, 0, 0], [1, 0, 0]]))
    assert abs(hits.z[0] - 0.8 / 0.5) < 1e-3 and hits.z[1] == np.inf
    assert hits.part.tolist() == [0, -1]


@given(
    st.lists(
        st.tuples(*3 * [st.floats(-1, 1).map(lambda x: round(x, 2))]),
        min_size=2,
        max_size=5,
        unique=True,
    ),
    st.integers(3, 20),
)
@settings(deadline=None, max_examples=30)
def test_a_tube_is_closed_and_as_thick_as_it_says(points, sides):
    # A Bézier curve between different ends.
    line = curve([*points[:-1], [2, 2, 2]], 30)
    mesh = tube(line, 0.003, sides)
    edges = np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2))
    _, times = np.unique(edges, axis=0, return_counts=True)
    assert (times == 2).all()
    rings = mesh.p_WV[:-2].reshape(30, sides, 3)
    np.testing.assert_allclose(
        np.linalg.norm(rings - line[:, None], axis=2), 0.003, rtol=1e-6
    )


@pytest.mark.parametrize("kind", KINDS)
def test_scenes_repeat_hold_what_their_kind_says_and_have_room(kind):
    scene, again = draw_scene(5, kind), draw_scene(5, kind)
    for part, same in zip(scene.parts, again.parts, strict=True):
        np.testing.assert_array_equal(part.mesh.p_WV, same.mesh.p_WV)
        assert np.isfinite(part.mesh.p_WV).all()
    labels = {part.label for part in scene.parts}
    assert labels <= COLORS.keys()
    assert ("rod" in labels) == (kind in ("room", "rods"))
    assert ("leaf" in labels) == (kind in ("room", "plants"))
    assert (scene.parts[0].mesh.p_WV[:, 2] <= 0).all()
    case = Case(5, EXACT, 3, kind).taken()
    p_WC = case.capture.X_WC[:, :3, 3]
    assert (case.caster.nearest(p_WC).distance > CLEARANCE).all()
    assert (case.capture.depth > 0).mean() > 0.5


def test_a_point_on_a_pixels_ray_is_seen_by_that_pixel():
    """Through a bad lens, read row by row."""
    what = Disturbance(k1=0.05, principal=0.01, readout=0.03)
    cameras = true_cameras(walk(board()), np.arange(3) / RATE, what, 1)
    p_W, ray_W = cameras.rays(1)
    row, column = np.array([3, 120, 200, 237]), np.array([5, 160, 310, 20])
    z = np.array([0.5, 1.0, 2.0, 3.0])
    seen_W = p_W[row, 0] + z[:, None] * ray_W[row, column]
    u, v, depth = cameras.project(1, seen_W)
    np.testing.assert_allclose(u, column + 0.5, atol=1e-3)
    np.testing.assert_allclose(v, row + 0.5, atol=1e-3)
    np.testing.assert_allclose(depth, z, rtol=1e-9)
    # By hand: the row in the middle is read at the time of the image, the
    # last but two 15 ms later, less two and a half rows.
    way = cameras.walk
    late = 0.03 * (237.5 / 240 - 0.5)
    np.testing.assert_allclose(
        p_W[237, 0], way.X_WC(np.array([0.1 + late]))[0, :3, 3], atol=1e-12
    )
    K = pinhole()
    assert np.hypot(*(cameras.K - K)[:2, 2]) == pytest.approx(0.01 * WIDTH)
    assert np.abs(Cameras(way, cameras.time, K).rays(0)[1][..., :]).max() < 2


def test_a_late_image_shows_what_an_older_pose_saw():
    scene = board()
    delayed = taken(scene, NAMED["delay 100 ms"])
    given, real = delayed.capture, delayed.perfect()
    np.testing.assert_array_equal(given.depth, real.depth)
    # At ten images a second each one shows what the pose before it saw.
    np.testing.assert_allclose(given.X_WC[:-1], real.X_WC[1:], atol=1e-12)
    np.testing.assert_array_equal(
        given.depth[1:], board_taken().capture.depth[:-1]
    )
    # The motion of 60 degrees in 2 s, to and fro, is fastest in its middle.
    speed = np.deg2rad(30) * 2 * np.pi * 0.25
    spin, moved = np.split(given.velocity_W[10], 2)
    np.testing.assert_allclose(spin, [0, 0, speed], atol=1e-6)
    assert np.linalg.norm(moved) == pytest.approx(speed * np.cos(0.5), rel=1e-6)


def test_a_rolling_shutter_bends_what_a_turning_camera_sees():
    """A camera that turns by 1 rad/s and sees a pole in all rows."""
    pole = tube(np.array([[1.0, 0, -2], [1.0, 0, 2]]), 0.02)
    scene = MeshScene((Part("rod", pole),), np.zeros(3))

    class Turning(Walk):
        def X_WC(self, time):
            X = np.zeros((*np.shape(time), 4, 4))
            X[..., 3, 3] = 1
            R = Rotation.from_rotvec(np.multiply.outer(time, [0, 0, 1.0]))
            ahead = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0.0]])
            X[..., :3, :3] = R.as_matrix() @ ahead
            return X

    way = Turning(
        np.zeros(3), np.zeros(3), np.zeros((3, 1, 3)), np.zeros((4, 1, 3))
    )
    still = Cameras(way, np.array([0.0]), pinhole())
    rolling = dc.replace(still, readout=0.03)
    middle = []
    for cameras in (still, rolling):
        depth = cameras.images(RayCaster(scene))[1][0]
        middle.append([np.flatnonzero(row).mean() for row in depth])
    # Turned to the left by 15 mrad at the bottom, it sees the pole that much
    # farther right.
    angle = 0.03 * ((np.arange(HEIGHT) + 0.5) / HEIGHT - 0.5)
    expected = pinhole()[0, 0] * np.tan(angle)
    np.testing.assert_allclose(np.diff(middle, axis=0)[0], expected, atol=0.75)


def test_disturbances_are_as_large_as_they_say():
    scene = board()
    exact = board_taken().capture

    def shift(name: str) -> np.ndarray:
        given = taken(scene, NAMED[name]).capture
        return np.linalg.norm((given.X_WC - exact.X_WC)[:, :3, 3], axis=1)

    np.testing.assert_allclose(board_taken().perfect().depth, exact.depth)
    late = shift("late loop 80 mm")
    assert late[0] < 1e-9 and late[15] > 0.06 and (late[16:] < 1e-9).all()
    jump = shift("jump 40 mm")
    assert set(jump.round(6)) == {0.0, 0.04}
    assert (np.diff(jump) > -1e-9).all()
    hand = taken(scene, NAMED["hand-eye 5 mm, 2 deg"]).capture
    X_CD = np.linalg.inv(exact.X_WC) @ hand.X_WC
    np.testing.assert_allclose(
        X_CD, np.broadcast_to(X_CD[0], X_CD.shape), atol=1e-9
    )
    assert np.linalg.norm(X_CD[0, :3, 3]) == pytest.approx(0.005)
    turn = Rotation.from_matrix(X_CD[0, :3, :3]).magnitude()
    assert np.rad2deg(turn) == pytest.approx(2)
    square = taken(scene, NAMED["z^2 0.01"]).capture.depth
    np.testing.assert_allclose(
        square, exact.depth + 0.01 * exact.depth**2, rtol=1e-6
    )
    focal = taken(scene, NAMED["focal -3 %"]).capture
    assert focal.K[0, 0, 0] == pytest.approx(0.97 * exact.K[0, 0, 0])
    np.testing.assert_array_equal(focal.depth, exact.depth)


def test_velocities_are_those_of_poses():
    def turning(time):
        X = np.tile(np.eye(4), (len(time), 1, 1))
        turn = np.outer(time, [0, 0, 0.5])
        X[:, :3, :3] = Rotation.from_rotvec(turn).as_matrix()
        X[:, 0, 3] = 2 * time
        return X

    np.testing.assert_allclose(
        velocity_W(turning, np.array([1.0, 2.0])),
        np.tile([0, 0, 0.5, 2, 0, 0], (2, 1)),
        atol=1e-9,
    )


def test_flying_pixels_lie_between_both_sides_of_an_edge():
    exact = np.full((40, 60), 2.0)
    exact[:, 30:] = 1.0
    rng = np.random.default_rng(0)
    flown = with_flying_pixels(exact, exact, 0.3, rng)
    moved = np.argwhere(flown != exact)
    assert set(moved[:, 1]) == {29, 30}
    assert 0.15 < len(moved) / 80 < 0.45
    assert (flown[tuple(moved.T)] > 1).all() and (
        flown[tuple(moved.T)] < 2
    ).all()
    np.testing.assert_array_equal(
        with_flying_pixels(exact, exact, 0.0, rng), exact
    )


def test_drawn_cases_repeat_and_splits_share_none():
    assert draw_case(7) == draw_case(7)
    develop, frozen = cases("develop", 0, 40), cases("frozen", 0, 40)
    assert not {c.seed for c in develop} & {c.seed for c in frozen}
    assert len({c.key for c in develop + frozen}) == 80
    assert any(c.disturbance == EXACT for c in develop)
    assert all(40 <= c.views <= 120 for c in develop)
    assert cases("named", 3, 1)[0].disturbance == NAMED["late loop 80 mm"]
    thin = thin_cases("frozen", 1, 6)
    assert [case.kind for case in thin] == [*THIN[1:], *THIN[:2]]
    assert [case.seed for case in thin] == [c.seed for c in frozen[1:7]]
    assert all(c.disturbance == EXACT for c in thin_cases("named", 0, 5))


def test_a_map_that_is_the_truth_has_no_error():
    dut = judge(splat_of_board(), board_sight(), np.random.default_rng(1))
    assert dut.all.count > 1000 and set(dut.by_label) == {"table"}
    assert abs(dut.all.over) < 1e-3 and dut.by_label["table"] == dut.all


def test_a_map_that_lies_too_low_is_found_out_by_that_much():
    low = splat_of_board(sunk=0.008)
    dut = judge(low, board_sight(), np.random.default_rng(1))
    assert dut.all.worst == dut.all.over == pytest.approx(0.008, abs=5e-4)
    assert dut.all.exceeded > 0.5 * dut.all.count
    careful = low.with_uncertainty(0.01)
    dut = judge(careful, board_sight(), np.random.default_rng(1))
    assert dut.all.over == pytest.approx(0.008, abs=5e-4)
    assert dut.all.worst < 0 and dut.all.exceeded == 0


def test_a_map_is_laid_on_the_truth_as_a_whole():
    case = board_taken()
    X_MW = RigidTransform(RollPitchYaw(0.1, -0.2, 0.3), [0.3, 0.1, -0.2])
    truth = splat_of_board()
    X_MC = X_MW.GetAsMatrix4() @ case.cameras.X_WC
    # The cameras know their poses to 10 mm only.
    X_MC[:, :3, 3] += 0.01
    dut = laid_on_truth(
        truth.transformed(X_MW), X_MC, case.cameras.X_WC, board_sight()
    )
    np.testing.assert_allclose(dut.p_GK, truth.p_GK, atol=2e-4)


def test_a_robot_in_a_board_is_found_out_and_one_on_the_floor_is_not():
    floor = Part("floor", box([-3, -3, -0.1], [3, 3, 0]))
    scene = board()
    scene = dc.replace(scene, parts=(floor, *scene.parts))
    truth = MeshTruth(Sight(taken(scene)))
    robot = load_robot("frankie", "paper", 0.03)
    before = np.array([-1.5, 0, 0, *robot.home])
    clearance, depth = truth.judged(robot, before[None])
    assert clearance > 0.1 and depth == 0
    way = np.array([[x, 0, 0, *robot.home] for x in np.linspace(-1.5, 0, 30)])
    clearance, depth = truth.judged(robot, way)
    assert clearance < -0.02 and 0 < depth <= -clearance


@pytest.mark.slow
def test_places_are_sought_where_the_map_is_wrong():
    sight = board_sight()
    low = splat_of_board(sunk=0.008)
    raw = SphereToEllipsoidField(low)
    careful = SphereToEllipsoidField(low.with_uncertainty(0.003))
    dut = find_places(sight, careful, raw, seed=1)
    assert len(dut.p_W) > 1000
    worst = dut.worst(1)[0]
    assert dut.excess[worst] == pytest.approx(0.005, abs=5e-4)
    assert dut.over[worst] == pytest.approx(0.008, abs=5e-4)
    assert dut.p_W[worst][2] == pytest.approx(TOP, abs=1e-4)
    assert dut.inward_W[worst][2] < -0.9


def test_surfaces_are_seen_that_face_cameras_and_are_not_hidden():
    case, sight = board_taken(), board_sight()
    queries = random_queries(sight, 2000, np.random.default_rng(2))
    assert (queries.distance > NEAREST).all()
    assert (queries.distance < FARTHEST).all()
    # Cameras look down on it from +x.
    top = case.caster.nearest(np.array([[0.0, 0, TOP + 0.1]]))
    under = case.caster.nearest(np.array([[0.0, 0, TOP - 0.15]]))
    behind = case.caster.nearest(np.array([[-0.6, 0, TOP - 0.02]]))
    assert sight.seen(top)[0] and not sight.seen(under)[0]
    assert not sight.seen(behind)[0]


@pytest.mark.parametrize(
    ("factor", "seen"), [(0.0, False), (1.05, True), (1.2, False)]
)
def test_a_surface_is_seen_if_its_own_depth_was_measured(factor, seen):
    """A pixel may have no depth, or that of the background."""
    case = board_taken()
    top = case.caster.nearest(np.array([[0.0, 0, TOP + 0.1]]))
    other = dc.replace(case.capture, depth=factor * case.capture.depth)
    dut = Sight(dc.replace(case, capture=other))
    assert dut.seen(top)[0] == [seen]


@pytest.mark.parametrize(("row", "seen"), [(0.5, False), (1.5, True)])
def test_a_surface_at_the_border_of_an_image_is_not_seen(row, seen):
    """The principal point is moved so that a point is in a given row."""
    case = board_taken()
    near = case.caster.nearest(np.array([[0.0, 0, TOP + 0.1]]))
    _, before, z = case.cameras.project(0, near.p_W)
    K = case.cameras.K.copy()
    K[1, 2] += row - before[0]
    capture = dc.replace(case.capture, depth=0 * case.capture.depth + z[0])
    cameras = dc.replace(case.cameras, K=K)
    sight = Sight(dc.replace(case, capture=capture, cameras=cameras))
    assert np.isfinite(sight._seen_at(0, near)) == [seen]


def test_a_point_far_outside_the_image_is_in_no_pixel():
    """A lens's polynomial turns back far outside the image.

    At slope 6, its factor 1 - 0.03 * 36 would place a point near the centre.
    """
    cameras = true_cameras(walk(board()), np.zeros(1), Disturbance(k1=-0.03), 1)
    X_WC = cameras.X_WC[0]
    p_C = np.array([[0.1, 0.1, 1.0], [6.0, 0.0, 1.0]])
    p_W = p_C @ X_WC[:3, :3].T + X_WC[:3, 3]
    u, v, z = cameras.project(0, p_W)
    shrunk = 1 - 0.03 * 0.02
    assert u[0] == pytest.approx(WIDTH / 2 + 0.1 * shrunk * pinhole()[0, 0])
    assert np.isnan(u[1]) and np.isnan(v[1])
    np.testing.assert_allclose(z, 1)


@pytest.mark.parametrize(("diameter", "wide"), [(0.0025, False), (0.016, True)])
def test_what_is_thinner_than_a_pixel_is_told_apart(diameter, wide):
    """Pixels are 3.6 mm apart at 1 m."""
    rod = tube(np.array([[0, 0, -0.2], [0, 0, 0.2]]), diameter / 2)
    scene = MeshScene((Part("rod", rod),), np.zeros(3))
    case = taken(scene)
    near = case.caster.nearest(np.array([[0.1, 0, 0.01], [0.1, 0, 0.03]]))
    # Independent of what the pixels between have met.
    depth = np.empty_like(case.capture.depth)
    for view in range(len(depth)):
        depth[view] = case.cameras.project(view, near.p_W)[2].mean()
    capture = dc.replace(case.capture, depth=depth)
    sight = Sight(dc.replace(case, capture=capture))
    seen, is_wide = sight.seen(near)
    assert seen.all() and (is_wide == wide).all()


def result(verdict: float, worst: float, wrong: str = "", **other) -> Result:
    errors = CameraErrors(0.0, 0.0, 0.0, 0.0)
    excess = Excess(100, int(worst > 0), worst, worst)
    return Result(
        f"{verdict} {worst}",
        wrong,
        verdict=verdict,
        map_error=verdict,
        before=errors,
        after=errors,
        all=excess,
        thin=excess,
        by_label={"leaf": excess},
        medium=0.002,
        seconds=(1.0, 2.0),
        **other,
    )


def test_verdicts_are_compared_with_the_truth():
    results = [
        result(0.01, 0.001),
        result(0.02, 0.003, "kinect"),
        result(0.03, 0.002, "delay"),
        result(0.001, 0.004, "focal"),
        Result("broken", error="Traceback\nno depth"),
    ]
    good = results[:-1]
    # Ranks 2 3 4 1 and 1 3 2 4: squared differences 1 0 4 9.
    for error in ("over", "worst"):
        assert report.correlation(good, error) == pytest.approx(1 - 6 * 14 / 60)
    assert [r.is_below for r in good] == [False, False, False, True]
    assert [r.is_runnable for r in good] == [True, False, False, True]
    refused = result(0.01, 0.001, defects=("poses",))
    assert not refused.is_runnable and report.says(refused).startswith("refu")
    lines = report.summary(results)
    assert lines[0].startswith("4 of 5 trials")
    assert "99.000 %" in lines[1] and "worst by 4.0 mm" in lines[1]
    assert lines[2].startswith("those to what is under a pixel wide")
    assert lines[4].startswith("called safe below the true error: 1 of 4")
    assert lines[5].startswith("of those that run: 1 of 2")
    assert lines[6] == "exact captures that run: 1 of 1"
    assert "leaf" in lines[7] and "of 400" in lines[7]
    assert report.table(results).row_count == 5


def test_results_come_back_from_their_lines():
    there = result(0.01, -0.002, warnings=("inexact",))
    assert restored(json.loads(json.dumps(dc.asdict(there)))) == there


def test_a_rod_is_beside_the_points_that_are_asked():
    setup = rods.Setup(0.9, 20.0, True)
    rays = RayCaster(setup.scene())
    for number in range(len(rods.DIAMETERS)):
        near = rays.nearest(setup.beside(number))
        np.testing.assert_allclose(near.distance, rods.BESIDE, atol=2e-4)
        assert (near.part == number).all()
    assert setup.pitch == pytest.approx(0.9 / 216.5, rel=1e-3)


@pytest.mark.parametrize(
    ("flags", "problem"),
    [
        (["--count", "0"], "--count: must be at least 1"),
        (["--first", "-1"], "--first: must be at least 0"),
        (["--jobs", "-1"], "--jobs: must be at least 0"),
        (["--attacks", "-1"], "--attacks: must be at least 0"),
        (["--rods", "--count", "0"], "--count: must be at least 1"),
    ],
)
def test_flags_out_of_range_end_in_one_line(capsys, flags, problem):
    assert main(flags) == 2
    assert problem in capsys.readouterr().err


def test_what_is_there_is_not_done_again(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    (case,) = cases("frozen", 2, 1)
    there = dc.replace(result(0.01, 0.002), key=case.key)
    file = tmp_path / "frozen.jsonl"
    file.write_text(json.dumps(dc.asdict(there)) + "\n")
    flags = ["--split", "frozen", "--first", "2", "--count", "1"]
    assert main([*flags, "--jobs", "0", "--output", str(tmp_path)]) == 0
    assert "worst by 2.0 mm" in capsys.readouterr().out
    file.write_text('{"key": 3}\n')
    assert main([*flags, "--jobs", "0", "--output", str(tmp_path)]) == 2
    assert "line 1 is no result" in capsys.readouterr().err


def test_attacks_of_earlier_runs_are_summed_up(tmp_path, capsys):
    (case,) = thin_cases("frozen", 0, 1)
    run = Attack("live", -0.002, 0.001, 0.022, 0.0, 0.04)
    there = Attacks(Aim(case, 1).key, (run,), ("offline",))
    file = tmp_path / "frozen-attacks.jsonl"
    file.write_text(json.dumps(dc.asdict(there)) + "\n")
    flags = ["--split", "frozen", "--count", "1", "--attacks", "1"]
    assert main([*flags, "--jobs", "0", "--output", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "1 maps that robots must not use" in out
    assert "live: 1 runs" in out and "22.0 mm at least" in out


@pytest.mark.slow
def test_live_maps_of_thin_things_are_attacked():
    result = attack_case(Aim(Case(1, EXACT, 20, "rods"), 1))
    assert not result.error
    assert {run.map for run in result.runs} >= {"live", "live, unseen solid"}
    assert all(run.depth == 0 < run.clearance for run in result.runs)


@pytest.mark.slow
def test_a_trial_of_an_exact_capture_finds_a_good_map():
    dut = run_trial(Case(2, EXACT, 16, "solids"))
    assert not dut.error and not dut.defects
    assert dut.all.count > 1000 and dut.all.worst < 0.01
    assert dut.after.position < 1e-3 and dut.verdict > 0
    assert {"table", "wall"} <= set(dut.by_label)


@pytest.mark.slow
def test_rods_are_measured_from_the_command_line(capsys):
    assert main(["--rods", "--count", "1"]) == 0
    out = capsys.readouterr().out
    assert "offline" in out and "unseen solid" in out
