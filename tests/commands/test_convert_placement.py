"""`remosplat convert` makes splats metric and upright, and says how."""

import re

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.resources import models_dir
from remosplat_drake.commands.main import USER_ERROR, main
from remosplat_drake.splat.formats import read_splat, write_splat
from remosplat_drake.splat.gaussian_splat import GaussianSplat

TABLE = models_dir() / "scenes/table/splat.ply"


def convert(*arguments) -> int:
    return main(["convert", *map(str, arguments)])


@pytest.fixture
def dots(tmp_path):
    """Four splats: the origin, x = 1, y = 2 and z = 3."""
    splat = GaussianSplat(
        p_GK=[[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]],
        quaternions=np.tile([1.0, 0, 0, 0], (4, 1)),
        scales=np.full((4, 3), 0.1),
        opacities=np.full(4, 0.6),
        colors=np.full((4, 3), 0.2),
        uncertainty=np.full(4, 0.01),
    )
    write_splat(tmp_path / "dots.ply", splat)
    return tmp_path / "dots.ply"


def test_a_scale_makes_all_lengths_larger(dots, capfd):
    assert convert(dots, dots.parent / "b.ply", "--scale", "2.5") == 0
    said = capfd.readouterr().out
    assert "Scaled by 2.5: 96 % of the splats now lie within" in said
    assert "b.ply: PLY, 4 3DGS ellipsoids, colours of degree 0, uncertain" in (
        said
    )
    assert "uncertain by up to 25.0 mm" in said
    splat = read_splat(dots.parent / "b.ply")
    np.testing.assert_allclose(splat.p_GK[3], [0, 0, 7.5])
    np.testing.assert_allclose(splat.scales, 0.25, rtol=1e-6)
    np.testing.assert_allclose(splat.uncertainty, 0.025, rtol=1e-6)


def test_a_measured_distance_tells_the_scale(dots, capfd):
    points = [0, 0, 0, 0, 0, 3, 1.5]
    assert convert(dots, dots.parent / "b.ply", "--scale-by", *points) == 0
    assert "Scaled by 0.5: " in capfd.readouterr().out
    splat = read_splat(dots.parent / "b.ply")
    np.testing.assert_allclose(splat.p_GK[3], [0, 0, 1.5])


def test_points_are_those_of_the_file_and_crop_scale_align_in_turn(dots, capfd):
    """On z = 3, with x along the file's -z and y along its x."""
    flags = ["--align-points", 0, 0, 3, 0, 0, 1, 4, 0, -2]
    flags += ["--scale", 2, "--crop", -9, -9, -9, 9, 1.5, 9]
    assert convert(dots, dots.parent / "b.ply", *flags) == 0
    said = capfd.readouterr().out
    turned = "The input's z axis is turned by 90.0 degrees, so that the three"
    assert f"{turned} points" in said
    splat = read_splat(dots.parent / "b.ply")
    expected = [[6, 0, 0], [6, 2, 0], [0, 0, 0]]
    np.testing.assert_allclose(splat.p_GK, expected, atol=1e-5)


def test_points_in_the_wrong_order_are_asked_about(dots, capfd):
    flags = ["--align-points", 0, 0, 0.5, 0, 1, 0.5, 1, 0, 0.5]
    assert convert(dots, dots.parent / "b.ply", *flags) == 0
    said = capfd.readouterr().out
    assert "turned by 180.0 degrees" in said
    assert "75 % of the splats are above the floor." in said
    flags = ["--align-points", 0, 0, 0.5, 1, 0, 0.5, 0, 1, 0.5]
    assert convert(dots, dots.parent / "b.ply", *flags) == 0
    said = capfd.readouterr().out
    assert (
        "25 % of the splats are above the floor. The points may be in clockwise"
        in said
    )


@pytest.mark.parametrize("up", [[], ["--up", "0", "-1e-3", "0"]])
def test_a_turned_scene_is_set_upright_on_its_floor(tmp_path, capfd, up):
    """As COLMAP has it: y is down, and the unit is anything."""
    table = read_splat(TABLE)
    X_VG = RigidTransform(RollPitchYaw(np.pi / 2, 0, 0), [0.5, 0.2, 1])
    write_splat(tmp_path / "a.ply", table.transformed(X_VG, 3.0))
    flags = ["--align", "floor", "--scale", 1 / 3, *up]
    assert convert(tmp_path / "a.ply", tmp_path / "b.ply", *flags) == 0
    said = capfd.readouterr().out
    share, beneath, turned, moved = map(
        float,
        re.search(
            r"Floor: (\d+) % of the splat's surface, with ([\d.]+) % beneath"
            r" it\. The input's z axis is turned by ([\d.]+) degrees,"
            r" and moved by (-?[\d.]+) m in height",
            said,
        ).groups(),
    )
    assert 40 < share < 60 and beneath < 1
    assert turned == pytest.approx(90, abs=0.2)
    # In V up is -y, and the floor y = 0.2.
    assert moved == pytest.approx(0.2 / 3, abs=2e-3)
    upright = read_splat(tmp_path / "b.ply")
    np.testing.assert_allclose(upright.p_GK[:, 2], table.p_GK[:, 2], atol=3e-3)
    np.testing.assert_allclose(upright.scales, table.scales, rtol=1e-5)


def test_without_a_clear_floor_people_are_asked(dots, capfd):
    room = models_dir() / "scenes/room/splat.ply"
    output = dots.parent / "b.ply"
    assert convert(room, output, "--align", "floor") == USER_ERROR
    error = capfd.readouterr().err
    assert "convert: --align: no clear floor: planes with" in error
    assert (
        "give an approximate upward direction by --up X Y Z, or three points"
        in error
    )
    assert error.count("\n") == 1
    assert not output.exists()


@pytest.mark.parametrize(
    ("flags", "problem"),
    [
        ("--scale 0", "--scale: must be positive"),
        ("--scale -2", "--scale: must be positive"),
        ("--scale nan", "--scale: must be positive"),
        ("--scale inf", "--scale: must be finite"),
        ("--scale 1e7", "--scale: must lie in [0.0001, 10000], got 1e+07"),
        ("--scale two", "'two' is not a number"),
        ("--scale-by 1 2 3 1 2 3 1", "--scale-by: the two points are equal"),
        ("--scale-by 1 2 3 1 2 4 0", "--scale-by: LENGTH must be positive"),
        ("--scale-by 1 2 3 1 2 4 -1", "--scale-by: LENGTH must be positive"),
        ("--scale-by 1 2 nan 1 2 4 1", "--scale-by: must be finite"),
        ("--scale-by 0 0 0 1e9 0 0 1", "--scale-by: must lie in"),
        ("--scale-by 0 0 0 1", "--scale-by: expected 7 arguments"),
        ("--scale 1 --scale-by 0 0 0 0 0 1 1", "not allowed with"),
        ("--align ceiling", "'ceiling'"),
        ("--align floor --align-points 0 0 0 1 0 0 0 1 0", "not allowed with"),
        ("--align-points 0 0 0 1 0 0 2 0 0", "the three points lie on one"),
        ("--align-points 0 0 0 1 0 0 0 0 0", "two of the three points are"),
        ("--align-points 0 0 0 1 0 0 0 nan 0", "--align-points: must be"),
        ("--align floor", "--align: no floor: there are only 4 splats"),
        ("--up 0 0 1", "--up: has an effect only with --align floor"),
        ("--align floor --up 0 0 0", "--up: must have a length > 0"),
        ("--align floor --up 0 1e-300 0", "--up: must have a length > 0"),
        ("--align floor --up 0 1e300 0", "--up: must be 1e+09 at most"),
        ("--align-points 0 0 0 1e300 0 0 0 1 0", "must be 1e+09 at most"),
        ("--scale-by 0 0 0 1e300 0 0 1", "--scale-by: must be 1e+09 at most"),
        ("--align floor --up 0 nan 0", "--up: must be finite"),
    ],
)
def test_one_line_says_what_is_wrong(dots, capfd, flags, problem):
    output = dots.parent / "b.ply"
    assert convert(dots, output, *flags.split()) == USER_ERROR
    error = capfd.readouterr().err
    assert problem in error
    assert error.count("\n") == 1
    assert not output.exists()
