"""The floor of a splat alone, in any frame and unit, or a clear refusal."""

import numpy as np
import pytest
from effort import effort
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.resources import models_dir
from remosplat_drake.reconstruction.splat_floor import (
    find_splat_floor,
    frame_of_points,
)
from remosplat_drake.splat.formats import read_splat
from remosplat_drake.splat.gaussian_splat import GaussianSplat

UP = np.array([0.0, 0, 1])


def patch(
    rng: np.random.Generator, origin, side, other, noise: float = 0.003
) -> GaussianSplat:
    """Thin ellipsoids on a parallelogram, 200 to its unit of area."""
    side, other = np.array(side, float), np.array(other, float)
    normal = np.cross(side, other)
    n = int(200 * np.linalg.norm(normal))
    normal /= np.linalg.norm(normal)
    a, b = rng.uniform(size=(2, n, 1))
    x = side / np.linalg.norm(side)
    R = np.stack([x, np.cross(normal, x), normal], axis=1)
    wxyz = RotationMatrix(R).ToQuaternion().wxyz()
    heights = noise * rng.normal(size=(n, 1))
    return GaussianSplat(
        p_GK=origin + a * side + b * other + heights * normal,
        quaternions=np.tile(wxyz, (n, 1)),
        scales=np.tile([0.03, 0.03, 0.002], (n, 1)),
        opacities=np.full(n, 0.9),
        colors=np.full((n, 3), 0.5),
    )


def blob(rng: np.random.Generator, n: int = 3000) -> GaussianSplat:
    """A ball of small splats."""
    return GaussianSplat(
        p_GK=rng.normal(size=(n, 3)),
        quaternions=rng.normal(size=(n, 4)),
        scales=np.full((n, 3), 0.01),
        opacities=np.full(n, 0.9),
        colors=np.full((n, 3), 0.5),
    )


def joined(parts: list[GaussianSplat]) -> GaussianSplat:
    splat = parts[0]
    for part in parts[1:]:
        splat = splat.joined_with(part)
    return splat


def kitchen(*, wall: float) -> GaussianSplat:
    """A floor of 9 m^2 at z = 0, a table, a wall, floaters and background."""
    rng = np.random.default_rng(2)
    floaters = blob(rng, 300).transformed(RigidTransform([1.5, 1.5, 0.5]), 0.5)
    return joined(
        [
            patch(rng, [0, 0, 0], [3, 0, 0], [0, 3, 0]),
            patch(rng, [1, 1, 0.7], [1.2, 0, 0], [0, 0.8, 0]),
            patch(rng, [0, 3, 0], [3, 0, 0], [0, 0, wall]),
            floaters.select(floaters.p_GK[:, 2] > -0.3),
            blob(rng, 150).transformed(RigidTransform([0, 0, 5.0]), 30),
        ]
    )


angle = st.floats(-np.pi, np.pi)


@settings(max_examples=effort(5, 15))
@given(rpy=st.tuples(angle, angle, angle), exponent=st.floats(-2, 2))
def test_a_floor_is_found_in_any_frame_and_unit(rpy, exponent):
    scale = 10**exponent
    X_VG = RigidTransform(RollPitchYaw(rpy), [0.3 * scale, -2 * scale, scale])
    floor = find_splat_floor(kitchen(wall=0.8).transformed(X_VG, scale))
    X_FG = floor.X_FG @ X_VG
    assert X_FG.rotation().matrix()[2, 2] > np.cos(np.radians(0.5))
    origin = X_FG @ (scale * np.array([1.5, 1.5, 0]))
    assert abs(origin[2]) < 0.005 * scale
    assert 0.4 < floor.share < 0.8 and floor.beneath < 0.02


def test_the_same_seed_finds_the_same_floor():
    found = [find_splat_floor(kitchen(wall=0.5), seed=3) for _ in "ab"]
    assert found[0].X_FG.IsExactlyEqualTo(found[1].X_FG)


def test_a_wall_as_large_as_the_floor_is_a_matter_for_people():
    splat = kitchen(wall=2.5)
    with pytest.raises(RemoSplatError, match=r"(89|90) degrees apart, might"):
        find_splat_floor(splat)
    floor = find_splat_floor(splat, up_G=[0.3, 0.3, 2.0])
    assert floor.X_FG.rotation().matrix()[2, 2] > np.cos(np.radians(0.5))
    assert abs((floor.X_FG @ [1.5, 1.5, 0])[2]) < 0.005


def test_what_is_called_up_decides_on_the_side():
    """A ceiling is a floor if up is reversed."""
    rng = np.random.default_rng(1)
    floor = patch(rng, [0, 0, 0], [3, 0, 0], [0, 3, 0])
    ceiling = patch(rng, [0, 0, 2.5], [3, 0, 0], [0, 3, 0])
    room = joined([floor, ceiling])
    with pytest.raises(RemoSplatError, match="180 degrees apart"):
        find_splat_floor(room)
    assert abs(find_splat_floor(room, UP).X_FG.translation()[2]) < 1e-3
    upside_down = find_splat_floor(room, -UP).X_FG
    np.testing.assert_allclose(upside_down @ [0, 0, 2.5], 0, atol=2e-2)
    assert upside_down.rotation().matrix()[2, 2] < -0.999


@pytest.mark.parametrize("scene", ["table", "bookshelf"])
def test_shipped_scenes_stand_upright_already(scene):
    splat = read_splat(models_dir() / "scenes" / scene / "splat.ply")
    X_FG = find_splat_floor(splat).X_FG
    assert X_FG.IsNearlyEqualTo(RigidTransform(), 2e-3)


def test_a_table_top_is_no_floor():
    """It is larger, but something is beneath it."""
    rng = np.random.default_rng(4)
    splat = joined(
        [
            patch(rng, [0, 0, 0.7], [2, 0, 0], [0, 2, 0]),
            patch(rng, [-0.5, -0.5, 0], [3, 0, 0], [0, 1, 0]),
        ]
    )
    assert abs(find_splat_floor(splat, UP).X_FG.translation()[2]) < 1e-3


def test_a_small_flat_side_is_a_floor_only_under_what_is_called_up():
    rng = np.random.default_rng(6)
    lump = blob(rng).transformed(RigidTransform([0, 0, 1.2]), 0.5)
    lump = lump.select(lump.p_GK[:, 2] > 0.1)
    plate = patch(rng, [-0.5, -0.5, 0.0], [1, 0, 0], [0, 1, 0])
    splat = joined([plate.select(np.arange(len(plate)) % 20 == 0), lump])
    with pytest.raises(RemoSplatError, match="nothing beneath it has 1"):
        find_splat_floor(splat)
    assert find_splat_floor(splat, UP).share < 0.15


@pytest.mark.parametrize("up_G", [None, UP])
def test_a_ball_has_no_floor(up_G):
    splat = blob(np.random.default_rng(0))
    with pytest.raises(RemoSplatError, match="no clear floor: the "):
        find_splat_floor(splat, up_G)


def test_a_point_has_no_floor():
    splat = blob(np.random.default_rng(0)).transformed(RigidTransform(), 1e-4)
    with pytest.raises(RemoSplatError, match="at the same point"):
        find_splat_floor(splat.select(np.zeros(200, int)))


@pytest.mark.parametrize("n", [1, 2, 3, 50])
def test_a_few_splats_show_no_floor(n):
    splat = blob(np.random.default_rng(0), n)
    with pytest.raises(RemoSplatError, match=f"there are only {n} splats"):
        find_splat_floor(splat)


def test_three_points_make_a_frame():
    """On a wall in the plane x = 1, whose floor frame has z along -x."""
    X_FG = frame_of_points(
        np.array([1.0, 2, 3]), np.array([1.0, 2, 5]), np.array([1.0, 7, 4])
    )
    np.testing.assert_allclose(X_FG @ [1, 2, 3], [0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(X_FG @ [1, 2, 5], [2, 0, 0], atol=1e-12)
    np.testing.assert_allclose(X_FG @ [1, 7, 4], [1, 5, 0], atol=1e-12)
    np.testing.assert_allclose(X_FG @ [0, 2, 3], [0, 0, 1], atol=1e-12)


@pytest.mark.parametrize(
    ("points", "problem"),
    [
        ([[0, 0, 0], [0, 0, 0], [1, 0, 0]], "two of the three"),
        ([[0, 0, 0], [1, 0, 0], [0, 0, 0]], "two of the three"),
        ([[0, 0, 0], [1, 0, 0], [1, 0, 0]], "two of the three"),
        ([[0, 0, 0], [1, 0, 0], [5, 0.01, 0]], "lie on one line"),
        ([[0, 0, 0], [1, 1, 1], [-2, -2, -2]], "lie on one line"),
    ],
)
def test_points_without_a_plane_are_refused(points, problem):
    with pytest.raises(RemoSplatError, match=problem):
        frame_of_points(*np.array(points, float))
