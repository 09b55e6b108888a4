"""The meshes of `remosplat bench mesh` are the scene, for any library."""

import numpy as np
import pytest

from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.timing.mesh_cases import QUERIES, table
from remosplat_drake.timing.optional_packages import is_there
from remosplat_drake.timing.oracle_cases import robot_spheres
from remosplat_drake.timing.primitive_mesh import SECTORS, surface_triangles

LONGEST = 0.3


def test_the_triangles_cover_the_primitives_and_nothing_else():
    scene = table()
    coarse, fine = surface_triangles(scene), surface_triangles(scene, LONGEST)
    exact = sum(
        8 * (x * y + y * z + z * x)
        for x, y, z in (box.half_extents for box in scene.boxes)
    )
    exact += sum(
        2 * np.pi * each.radius * (each.radius + 2 * each.half_height)
        for each in scene.cylinders
    )
    assert area(coarse) == pytest.approx(exact, rel=1e-3)
    assert area(fine) == pytest.approx(area(coarse), rel=1e-9)
    corners = Spheres.at(fine.reshape(-1, 3))
    # Each is on its own primitive's surface, and on or in another's.
    assert SignedDistanceField(scene).clearances(corners).distance.max() < 1e-9


def test_triangles_are_cut_until_no_edge_is_too_long():
    edges = surface_triangles(table(), LONGEST)
    edges = edges - np.roll(edges, 1, axis=1)
    assert np.linalg.norm(edges, axis=2).max() <= LONGEST


@pytest.mark.parametrize("name", QUERIES)
@pytest.mark.parametrize("longest", [np.inf, LONGEST])
def test_others_find_the_points_that_are_closest(name, longest):
    query, scene = QUERIES[name], table()
    if not all(map(is_there, query.packages)):
        pytest.skip(f"needs the packages {' and '.join(query.packages)}")
    p_WS = robot_spheres().p_WS
    exact = SignedDistanceField(scene).clearances(Spheres.at(p_WS)).distance
    assert exact.min() > 0.0
    p_WC = query.make(surface_triangles(scene, longest))(p_WS)
    distance = np.linalg.norm(p_WC - p_WS, axis=1)
    # Polygons are within their circles.
    radius = max(each.radius for each in scene.cylinders)
    within = radius * (1.0 - np.cos(np.pi / SECTORS))
    assert (distance >= exact - 1e-6).all()
    assert (distance <= exact + within + 1e-6).all()


def test_our_surfels_are_the_same_scene_and_err_on_the_safe_side():
    scene = table()
    points = Spheres.at(robot_spheres().p_WS)
    exact = SignedDistanceField(scene).clearances(points).distance
    ours = SphereToEllipsoidField(surfel_splat(scene)).clearances(points)
    assert (ours.distance <= exact + 1e-4).all()
    np.testing.assert_allclose(ours.distance, exact, rtol=0.0, atol=0.02)


def area(triangles: np.ndarray) -> float:
    a, b, c = np.moveaxis(triangles, 1, 0)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
