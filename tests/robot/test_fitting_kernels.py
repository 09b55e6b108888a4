"""The kernels of the fits agree with readable references."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RollPitchYaw
from scipy import ndimage
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from remosplat_drake.robot.fitting.convex_pieces import below
from remosplat_drake.robot.fitting.kernels.best_plane import best_plane
from remosplat_drake.robot.fitting.kernels.distance_transform import (
    squared_distances,
)
from remosplat_drake.robot.fitting.kernels.points_distance import (
    points_distances,
)
from remosplat_drake.robot.fitting.kernels.sphere_cover import (
    close_covered,
    count_covered,
    enclosing_radii,
    move_centers,
    needed_bulges,
)
from remosplat_drake.robot.fitting.point_tree import point_tree
from remosplat_drake.robot.fitting.simplified import welded
from remosplat_drake.robot.fitting.solid_grid import SolidGrid
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.robot.self_collision.hull_distance_reference import (
    nearest_to_origin,
)
from remosplat_drake.robot.self_collision.kernels.all_distances import (
    pair_distances,
)
from remosplat_drake.robot.self_collision.kernels.nearest_shapes import (
    nearest_shapes,
)
from remosplat_drake.robot.self_collision.link_pairs import find_link_pairs
from remosplat_drake.robot.self_collision.shape_pairs import ShapePairs
from remosplat_drake.robot.self_collision.shapes import read_collision_shapes

SEEDS = st.integers(0, 10_000)


def pose(rng: np.random.Generator) -> np.ndarray:
    turn = RollPitchYaw(rng.uniform(-3, 3, 3)).ToRotationMatrix()
    return RigidTransform(turn, rng.uniform(-1, 1, 3)).GetAsMatrix4()


@given(SEEDS, st.integers(1, 200), st.integers(1, 200))
def test_points_are_as_far_apart_as_the_nearest_two(seed, n_a, n_b):
    rng = np.random.default_rng(seed)
    p_A, p_B = rng.uniform(0, 1, (n_a, 3)), rng.uniform(0, 1, (n_b, 3))
    a, b = point_tree(p_A), point_tree(p_B)
    X_AB = np.array([pose(rng) for _ in range(5)])
    within = rng.uniform(0.2, 1.5, 5)
    found, at_a, at_b = points_distances(a, b, X_AB, np.zeros(5), within)
    for i, X in enumerate(X_AB):
        placed = p_B @ X[:3, :3].T + X[:3, 3]
        least = KDTree(p_A).query(placed)[0].min()
        if least >= within[i]:
            assert found[i] == np.inf
            assert at_a[i] == at_b[i] == -1
            continue
        np.testing.assert_allclose(found[i], least, atol=1e-12)
        q = X[:3, :3] @ b.values.points[at_b[i]] + X[:3, 3]
        way = np.linalg.norm(a.values.points[at_a[i]] - q)
        np.testing.assert_allclose(way, least, atol=1e-12)


def test_the_least_distance_does_not_matter_where_another_is_small_enough():
    p = np.random.default_rng(3).uniform(0, 1, (500, 3))
    tree, X_AB = point_tree(p), np.eye(4)[None]
    found, _, _ = points_distances(
        tree, tree, X_AB, np.array([0.05]), np.ones(1)
    )
    assert found[0] <= 0.05


@given(SEEDS, st.integers(0, 9), st.integers(1, 3000))
def test_balls_contain_their_points_and_are_halved(seed, digits, n):
    """With fewer digits, more points have equal coordinates."""
    p = np.random.default_rng(seed).uniform(0, 1, (n, 3)).round(digits)
    tree = point_tree(p).values
    np.testing.assert_array_equal(
        tree.points[np.lexsort(tree.points.T)], p[np.lexsort(p.T)]
    )
    assert (tree.first[0], tree.last[0]) == (0, n)
    for ball, right in enumerate(tree.right):
        own = tree.points[tree.first[ball] : tree.last[ball]]
        away = np.linalg.norm(own - tree.center[ball], axis=1)
        np.testing.assert_allclose(tree.radius[ball], away.max())
        if right < 0:
            assert 1 <= len(own) <= 8
            continue
        assert tree.first[ball + 1] == tree.first[ball]
        assert tree.last[ball + 1] == tree.first[right]
        assert tree.last[right] == tree.last[ball]
        middle = tree.first[right] - tree.first[ball]
        assert middle == len(own) // 2
        axis = np.ptp(own, axis=0).argmax()
        assert own[:middle, axis].max() <= own[middle:, axis].min()


@given(SEEDS, st.sampled_from([0.0, 0.001, 0.1, 0.9]))
def test_voxels_are_as_far_as_the_nearest_marked_one(seed, share):
    rng = np.random.default_rng(seed)
    marked = rng.random(rng.integers(1, 30, 3)) < share
    found = squared_distances(marked)
    if marked.any():
        true = np.asarray(ndimage.distance_transform_edt(~marked))
        np.testing.assert_array_equal(found, np.rint(true**2))
    else:
        assert (found >= sum(marked.shape) ** 2).all()


@given(SEEDS)
def test_a_cover_counts_each_open_point_once(seed):
    rng = np.random.default_rng(seed)
    points, centers = rng.uniform(0, 1, (80, 3)), rng.uniform(0, 1, (30, 3))
    depth = rng.uniform(0, 0.2, 30)
    need = needed_bulges(points, centers, depth)
    np.testing.assert_allclose(need, cdist(points, centers) - depth, atol=1e-6)
    bulge = np.float32(0.3)
    gain, is_open = count_covered(need, bulge), np.ones(80, bool)
    for chosen in range(5):
        close_covered(need, bulge, chosen, is_open, gain)
        covers = need <= bulge
        np.testing.assert_array_equal(is_open, ~covers[:, : chosen + 1].any(1))
        np.testing.assert_array_equal(gain, covers[is_open].sum(axis=0))


@given(SEEDS)
def test_centers_move_to_the_neighbour_that_needs_the_least_bulge(seed):
    rng = np.random.default_rng(seed)
    grid = SolidGrid(rng.uniform(-0.1, 0.1, 3), 0.1, rng.random((9, 12, 11)))
    points, before = rng.uniform(0, 1, (60, 3)), rng.uniform(-0.2, 1.2, (4, 3))
    owner = (cdist(points, before) - grid.depth_at(before)).argmin(axis=1)
    centers, step, lowest = before.copy(), 0.15, 0.1
    move_centers(
        points, centers, lowest, step, grid.depth, grid.origin, grid.pitch
    )
    steps = step * (np.indices((3, 3, 3)).reshape(3, -1).T - 1)
    for k, center in enumerate(centers):
        own = points[owner == k]
        if len(own) == 0:
            np.testing.assert_array_equal(center, before[k])
            continue
        trials = before[k] + steps
        trials[:, 2] = np.maximum(trials[:, 2], lowest)
        bulges = cdist(trials, own).max(axis=1) - grid.depth_at(trials)
        best = np.linalg.norm(own - center, axis=1).max()
        best -= grid.depth_at(center[None])[0]
        np.testing.assert_allclose(best, bulges.min(), atol=1e-12)
        assert np.abs(trials - center).max(axis=1).min() < 1e-12


@given(SEEDS)
def test_spheres_enclose_the_points_that_they_cover_with_least_bulge(seed):
    rng = np.random.default_rng(seed)
    points, centers = rng.uniform(0, 1, (60, 3)), rng.uniform(0, 1, (5, 3))
    depth = rng.uniform(0, 0.2, 5)
    away = cdist(points, centers)
    owner = (away - depth).argmin(axis=1)
    for k, radius in enumerate(enclosing_radii(points, centers, depth)):
        farthest = away[owner == k, k].max(initial=0.0)
        np.testing.assert_allclose(radius, farthest, atol=1e-12)


@given(SEEDS)
def test_the_best_plane_frees_points_most_from_the_halves(seed):
    rng = np.random.default_rng(seed)
    surface = rng.uniform(-1, 1, (12, 3, 3))
    vertices, triangles = welded(surface)
    ends = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    normal = rng.standard_normal((6, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    planes = np.column_stack([normal, rng.uniform(-0.5, 0.5, 6)])
    p, off = rng.uniform(-1.2, 1.2, (3, 3)), rng.uniform(0.02, 0.5, 3)
    whole = [distance(point, surface) for point in p]
    gain = []
    for n, offset in zip(normal, planes[:, 3], strict=True):
        halves = below(surface, n, offset), below(surface, -n, -offset)
        free = [
            min(distance(point, half) for half in halves if len(half))
            for point in p
        ]
        free = np.subtract(free, whole)
        gain.append((free > 0.01).any() * (np.minimum(free, off) @ off))
    best = best_plane(vertices, ends, planes, p, off, 0.01)
    found = gain[best] if best >= 0 else 0.0
    np.testing.assert_allclose(found, max(gain), atol=1e-5)


def distance(p: np.ndarray, surface: np.ndarray) -> float:
    """Of a point from the hull of a surface, by what it is."""
    return float(np.linalg.norm(nearest_to_origin(surface.reshape(-1, 3) - p)))


def test_links_are_nearest_where_their_nearest_shapes_are():
    robot = load_robot("fetch")
    shapes = read_collision_shapes(robot.description, robot.spheres)
    links = find_link_pairs(robot, shapes).watched
    pairs = ShapePairs.make(robot, shapes, links)
    arrays = pairs.arrays(np.zeros(len(pairs)))
    rng = np.random.default_rng(4)
    states = robot.q_home + rng.uniform(-1, 1, (20, robot.n_q))
    X_WLs = np.array([robot.body_poses(q) for q in states])
    reference = np.array([pair_distances(arrays, X, np.inf) for X in X_WLs])
    reference = np.minimum.reduceat(reference, pairs.start[:-1], axis=1)
    for i in range(len(links)):
        which, nearest, found, points = nearest_shapes(arrays, i, X_WLs, 0.2)
        near = np.flatnonzero(reference[:, i] < 0.2)
        np.testing.assert_array_equal(which, near)
        np.testing.assert_allclose(found, reference[near, i], atol=1e-9)
        # The points are as far apart, but for the radii of round shapes.
        way = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
        ends = np.stack([pairs.first[nearest], pairs.second[nearest]])
        radii = shapes.radius[ends].sum(axis=0)
        apart = found + radii > 0.0
        np.testing.assert_allclose(
            way[apart], (found + radii)[apart], atol=1e-6
        )
