"""Fitting spheres: worked examples, and a toy robot of three links."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.geometry import Box, Capsule, Cylinder, HalfSpace, Sphere
from pydrake.math import RotationMatrix

from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.robot.fitting.link_spheres import (
    LinkSpheres,
    measure_bulge,
)
from remosplat_drake.robot.fitting.link_surface import sample_shape
from remosplat_drake.robot.fitting.model_surfaces import (
    SurfaceOptions,
    model_surfaces,
    surface_points,
)
from remosplat_drake.robot.fitting.solid_grid import (
    SolidGrid,
    join_solids,
    make_solid_grid,
)
from remosplat_drake.robot.fitting.sphere_fitting import (
    POINTS_PER_VOXEL,
    fit_spheres,
    make_link_surface,
    voxel_pitch,
)

URDF = """
<robot name="toy" xmlns:drake="http://drake.mit.edu">
  <link name="ball"><collision><origin xyz="1 2 3"/>
    <geometry><sphere radius="0.5"/></geometry></collision></link>
  <link name="pill"><collision>
    <geometry><drake:capsule radius="0.1" length="0.6"/></geometry>
  </collision></link>
  <link name="brick"><collision><origin xyz="0 0 0.15"/>
    <geometry><box size="0.6 0.2 0.3"/></geometry></collision></link>
  <link name="bare"/>
  <joint name="a" type="fixed"><parent link="ball"/><child link="pill"/>
  </joint>
  <joint name="b" type="fixed"><parent link="pill"/><child link="brick"/>
  </joint>
  <joint name="c" type="fixed"><parent link="brick"/><child link="bare"/>
  </joint>
</robot>
"""


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    path = tmp_path_factory.mktemp("toy") / "toy.urdf"
    path.write_text(URDF)
    return path


@pytest.fixture(scope="module")
def surfaces(toy):
    return model_surfaces(toy, SurfaceOptions())


@pytest.fixture(scope="module")
def fits(surfaces):
    return fit_spheres(surfaces, 10, restarts=1)


def test_shapes_are_sampled_on_their_surface():
    rng = np.random.default_rng(0)
    p = sample_shape(Box(2, 4, 6), 0.3, rng)
    np.testing.assert_allclose((np.abs(p) / [1, 2, 3]).max(1), 1)
    p = sample_shape(Sphere(0.5), 0.1, rng)
    np.testing.assert_allclose(np.linalg.norm(p, axis=1), 0.5)
    p = sample_shape(Cylinder(0.5, 2), 0.1, rng)
    rho = np.hypot(p[:, 0], p[:, 1])
    np.testing.assert_allclose(
        np.maximum(rho / 0.5, np.abs(p[:, 2])), 1, atol=1e-9
    )
    p = sample_shape(Capsule(0.5, 2), 0.1, rng)
    p[:, 2] -= np.clip(p[:, 2], -1, 1)
    np.testing.assert_allclose(np.linalg.norm(p, axis=1), 0.5, atol=1e-9)


def test_half_space_has_no_surface_to_cover():
    with pytest.raises(RemoSplatError, match="HalfSpace"):
        sample_shape(HalfSpace(), 0.1, np.random.default_rng(0))


def test_depth_of_a_box():
    # 2 x 2 x 2 m around the origin, voxels of 5 cm.
    surface = sample_shape(Box(2, 2, 2), 0.02, np.random.default_rng(0))
    solid = make_solid_grid(surface, 0.05)
    p = np.array([[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [1.05, 0, 0], [3, 0, 0]])
    np.testing.assert_allclose(
        solid.depth_at(p), [1, 0.5, 0, -0.05, -2], atol=0.05
    )


def test_a_tube_with_open_ends_is_solid_and_a_trough_is_not():
    surface = sample_shape(Box(1, 1, 3), 0.02, np.random.default_rng(0))
    tube = surface[np.abs(surface[:, 2]) < 1.49]
    assert make_solid_grid(tube, 0.05).depth_at(np.zeros(3)) > 0.4
    trough = tube[tube[:, 0] < 0.49]
    assert make_solid_grid(trough, 0.05).depth_at(np.zeros(3)) < 0


def test_standing_on_the_floor_hides_the_underside():
    # 2 x 2 x 1 m on the floor: its mirror image doubles the height.
    surface = sample_shape(Box(2, 2, 1), 0.02, np.random.default_rng(0))
    surface += [0, 0, 0.5]
    p_low = np.array([0, 0, 0.1])
    free = make_solid_grid(surface, 0.05)
    np.testing.assert_allclose(free.depth_at(p_low), 0.1, atol=0.05)
    standing = make_solid_grid(surface, 0.05, floor=True)
    np.testing.assert_allclose(standing.depth_at(p_low), 0.9, atol=0.05)


def test_what_is_hidden_in_a_neighbour_is_deep():
    # A rod of 2 m whose last half metre is plugged into a cube, also when
    # the cube is turned about the rod's axis (z): the end counts as deep.
    rng = np.random.default_rng(0)
    rod = make_solid_grid(sample_shape(Cylinder(0.2, 2), 0.01, rng), 0.04)
    cube = make_solid_grid(sample_shape(Box(1, 1, 1), 0.02, rng), 0.04)
    poses = []
    for angle in (0.0, np.pi / 4):
        X_LN = np.eye(4)
        X_LN[:3, :3] = RotationMatrix.MakeZRotation(angle).matrix()
        X_LN[2, 3] = 1.0
        poses.append(X_LN)
    joined = join_solids(rod, [(cube, poses)])
    end = np.array([0, 0, 1.0])
    assert abs(rod.depth_at(end)) < 0.04
    assert joined.depth_at(end) > 0.15
    # A corner of the cube leaves its place when the cube turns.
    corner = np.array([0.28, 0.28, 1.0])
    assert joined.depth_at(corner) > 0
    assert joined.depth_at(np.array([0.45, 0.45, 1.0])) < 0


def test_no_voxel_is_left_out_where_something_is_shared(monkeypatch):
    """Turned and shifted neighbours, and one that is far away."""
    rng = np.random.default_rng(6)
    rod = make_solid_grid(sample_shape(Cylinder(0.1, 0.6), 0.01, rng), 0.02)
    cube = make_solid_grid(sample_shape(Box(0.5, 0.3, 0.4), 0.01, rng), 0.02)
    poses = []
    for angle in (0.0, 0.7, 1.4):
        pose = np.eye(4)
        pose[:3, :3] = RotationMatrix.MakeXRotation(angle).matrix()
        pose[:3, 3] = [0.05, 0.02, 0.3]
        poses.append(pose)
    far = np.eye(4)
    far[0, 3] = 9.0
    neighbours = [(cube, poses), (cube, [far])]
    joined, alone = join_solids(rod, neighbours), join_solids(rod, [])
    assert (joined.depth > alone.depth).sum() > 1000
    everywhere = np.full(3, -100.0), np.full(3, 100.0)
    monkeypatch.setattr(SolidGrid, "box", lambda grid, pose: everywhere)
    asked = join_solids(rod, neighbours)
    np.testing.assert_array_equal(joined.depth, asked.depth)


def test_bulge_of_a_circumscribed_sphere():
    # A cube of edge 2 in its circumscribed sphere, radius sqrt(3): the faces
    # are 1 away from the centre, so it stands out by sqrt(3) - 1.
    surface = sample_shape(Box(2, 2, 2), 0.02, np.random.default_rng(0))
    solid = make_solid_grid(surface, 0.05)
    sphere = LinkSpheres(np.zeros((1, 3)), np.array([np.sqrt(3)]))
    bulge = measure_bulge(sphere, solid)
    assert bulge.max == pytest.approx(np.sqrt(3) - 1, abs=0.03)
    assert 0.2 < bulge.mean < bulge.max


def test_grows_over_points_that_it_missed():
    two = LinkSpheres(np.array([[0.0, 0, 0], [4, 0, 0]]), np.ones(2))
    grown = two.grown_over(np.array([[0, 1.5, 0], [4, 0, 0.5]]), 0.25)
    np.testing.assert_allclose(grown.radius, [1.75, 1])


@pytest.mark.parametrize("thickness", [8e-4, 2e-3, 5e-3])
def test_a_sheet_thinner_than_its_voxels_is_covered_all_over(thickness):
    """Sixteen balls of 48 mm suffice for 300 mm by 200 mm."""
    sheet = Box(0.3, 0.2, thickness)
    pitch = voxel_pitch(np.array(sheet.size()))
    rng = np.random.default_rng(0)
    p = sample_shape(sheet, pitch / POINTS_PER_VOXEL, rng)
    surface = make_link_surface(p)
    fit = fit_spheres({"sheet": surface}, tolerance=0.02, restarts=1)["sheet"]
    assert fit.outside(p).max() <= 0
    assert measure_bulge(fit, surface.solid).max < 0.06


def test_one_sphere_around_a_sphere_is_that_sphere(surfaces):
    fit = fit_spheres({"ball": surfaces["ball"]}, 1)["ball"]
    np.testing.assert_allclose(fit.p_LS, [[1, 2, 3]], atol=0.01)
    np.testing.assert_allclose(fit.radius, [0.5], atol=0.015)


def test_links_without_geometry_are_left_out(surfaces):
    assert list(surfaces) == ["ball", "pill", "brick"]


def test_every_surface_point_is_inside_a_sphere(toy, fits):
    # Fresh points: other random numbers than the fit saw.
    fresh = surface_points(toy, SurfaceOptions(), seed=99)
    for link, points in fresh.items():
        assert fits[link].outside(points).max() <= 0, link


def test_spends_no_more_than_allowed_and_more_where_it_is_needed(fits):
    count = {link: len(fit.radius) for link, fit in fits.items()}
    assert sum(count.values()) <= 10
    assert count["ball"] == 1
    assert count["pill"] > 1


def test_a_pill_keeps_its_spheres_on_its_axis(surfaces, fits):
    assert np.abs(fits["pill"].p_LS[:, :2]).max() < 0.03
    assert measure_bulge(fits["pill"], surfaces["pill"].solid).max < 0.08


def test_more_spheres_bulge_less(surfaces):
    brick = {"brick": surfaces["brick"]}
    few, many = (fit_spheres(brick, n, restarts=1)["brick"] for n in (2, 10))
    solid = surfaces["brick"].solid
    assert measure_bulge(many, solid).max < measure_bulge(few, solid).max


def test_a_heavier_link_gets_more_spheres(surfaces, fits):
    heavy = dc.replace(surfaces["brick"], weight=2.0)
    again = fit_spheres({**surfaces, "brick": heavy}, 10, restarts=0)
    assert len(again["brick"].radius) > len(fits["brick"].radius)


def test_same_seed_same_spheres(surfaces):
    first, second = (
        fit_spheres({"brick": surfaces["brick"]}, 3, seed=3, restarts=1)[
            "brick"
        ]
        for _ in range(2)
    )
    np.testing.assert_array_equal(first.p_LS, second.p_LS)
    np.testing.assert_array_equal(first.radius, second.radius)


def test_impossible_wishes_are_refused(surfaces, toy, tmp_path):
    with pytest.raises(RemoSplatError, match="too few"):
        fit_spheres(surfaces, 2)
    with pytest.raises(RemoSplatError, match="no geometry"):
        make_link_surface(np.zeros((0, 3)))
    with pytest.raises(RemoSplatError, match="did you mean 'brick'"):
        model_surfaces(toy, SurfaceOptions(links=("brik",)))
    broken = tmp_path / "broken.urdf"
    broken.write_text("<robot")
    with pytest.raises(FileError, match=r"broken\.urdf"):
        model_surfaces(broken, SurfaceOptions())
