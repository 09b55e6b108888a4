"""`remosplat convert --clean` and `--guide`: what they do, say and refuse."""

import json
import re
import shlex

import numpy as np
import pytest
from planted_splat import PLANTED, with_junk
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.resources import models_dir
from remosplat_drake.commands.main import main
from remosplat_drake.splat.cleaning.junk import KEPT
from remosplat_drake.splat.formats import read_splat, write_splat

TABLE = models_dir() / "scenes/table/splat.ply"


def convert(*arguments) -> int:
    return main(["convert", *map(str, arguments)])


@pytest.fixture(scope="module")
def planted(tmp_path_factory):
    """A table with junk, as COLMAP has it: y is down, the unit anything."""
    folder = tmp_path_factory.mktemp("planted")
    splat, kinds = with_junk(read_splat(TABLE))
    X_VG = RigidTransform(RollPitchYaw(np.pi / 2, 0, 0.3), [0.5, 0.2, 1])
    write_splat(folder / "a.ply", splat.transformed(X_VG, 3.0))
    return folder / "a.ply", int((kinds == KEPT).sum())


def test_clean_removes_shows_and_promises_nothing(planted, tmp_path, capfd):
    source, kept = planted
    assert convert(source, tmp_path / "b.ply", "--clean") == 0
    said = capfd.readouterr().out
    assert len(read_splat(tmp_path / "b.ply")) == kept
    for kind in ("sky", "floater", "faint"):
        assert re.search(rf"{kind} .* {PLANTED[kind]:,} ", said), kind
    assert re.search(rf"in all +{sum(PLANTED.values()):,} ", said)
    assert "The error of the remaining splat has no bound" in said
    page = (tmp_path / "b.clean.html").read_text()
    assert page.count("<svg") == 2 and "along A&#x27;s" not in page
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "b.clean.html",
        "b.ply",
    ]


def test_a_guide_cleans_places_and_says_how_to_do_it_again(
    planted, tmp_path, capfd
):
    source, kept = planted
    length = np.linalg.norm
    table = read_splat(TABLE)
    flags = ["--clean", "--guide", "--length", "4.0"]
    assert convert(source, tmp_path / "b.ply", *flags) == 0
    said = capfd.readouterr().out
    again = shlex.split(
        re.search(r"Flags with the same effect as --guide: (.*)", said)[1]
    )
    assert again[:3] == ["--align", "floor", "--up"]
    first = read_splat(tmp_path / "b.ply")
    assert len(first) == kept
    assert "from above" in (tmp_path / "b.clean.html").read_text()
    # The floor is z = 0, and one unit is what the longest side tells.
    on_floor = np.abs(table.p_GK[:, 2]) < 0.005
    assert np.abs(first.p_GK[on_floor, 2]).max() < 0.02
    ratio = length(first.p_GK[0] - first.p_GK[-1]) / length(
        table.p_GK[0] - table.p_GK[-1]
    )
    assert float(again[-1]) == pytest.approx(ratio / 3, rel=1e-4)
    assert convert(source, tmp_path / "c.ply", "--clean", *again) == 0
    second = read_splat(tmp_path / "c.ply")
    np.testing.assert_allclose(second.p_GK, first.p_GK, atol=2e-3)


@pytest.mark.slow
def test_a_guide_without_a_length_says_that_the_unit_is_unknown(
    planted, tmp_path, capfd
):
    source, _ = planted
    assert convert(source, tmp_path / "b.ply", "--clean", "--guide") == 0
    said = capfd.readouterr().out
    assert "The length of a unit is unknown: give the true length" in said
    assert "--scale" not in said


def transforms(path, height: float):
    """A camera that looks down from above the table."""
    X_WC = np.eye(4)
    X_WC[2, 3] = height
    frame = {"transform_matrix": X_WC.tolist()}
    camera = {"w": 400, "h": 400, "fl_x": 100.0}
    path.write_text(json.dumps({**camera, "frames": [frame]}))
    return path


def test_cameras_are_told_or_lie_beside_the_splat(tmp_path, capfd):
    write_splat(tmp_path / "a.ply", read_splat(TABLE).select(slice(0, None, 9)))
    told = transforms(tmp_path / "cameras.json", 4.0)
    flags = ["--clean", "--views", told]
    assert convert(tmp_path / "a.ply", tmp_path / "b.ply", *flags) == 0
    said = capfd.readouterr().out
    assert f"{told}: 1 cameras show which space was seen." in said
    assert "before a camera" in said and "unseen" in said
    beside = transforms(tmp_path / "transforms.json", 4.0)
    assert convert(tmp_path / "a.ply", tmp_path / "b.ply", "--clean") == 0
    assert (
        f"{beside}: 1 cameras show which space was seen."
        in capfd.readouterr().out
    )


def test_cameras_of_another_frame_are_refused_or_left_aside(tmp_path, capfd):
    write_splat(tmp_path / "a.ply", read_splat(TABLE).select(slice(0, None, 9)))
    below = transforms(tmp_path / "transforms.json", -4.0)
    assert convert(tmp_path / "a.ply", tmp_path / "b.ply", "--clean") == 0
    said = capfd.readouterr().out
    assert f"{below}: not used: its cameras see only 0 % of the splats" in said
    flags = ["--clean", "--views", below]
    assert convert(tmp_path / "a.ply", tmp_path / "c.ply", *flags) == 2
    assert (
        "check whether the file has another frame or unit"
        in capfd.readouterr().err
    )
    assert not (tmp_path / "c.ply").exists()


@pytest.mark.parametrize(
    ("flags", "problem"),
    [
        (["--views", "v.json"], "--views: has an effect only with --clean"),
        (["--clean", "--views", "v.json"], "v.json: "),
        (["--length", "2"], "--length: has an effect only with --guide"),
        (["--guide", "--length", "0"], "--length: must be positive"),
        (["--guide", "--length", "nan"], "--length: must be"),
        (["--guide", "--scale", "2"], "--guide: finds this value itself"),
        (["--guide", "--align", "floor"], "--guide: finds this value itself"),
        (["--guide", "--length", "1e9"], "--length: would scale by"),
    ],
)
def test_mistakes(tmp_path, capfd, flags, problem):
    write_splat(tmp_path / "a.ply", read_splat(TABLE).select(slice(0, None, 9)))
    assert convert(tmp_path / "a.ply", tmp_path / "b.ply", *flags) == 2
    error = capfd.readouterr().err
    assert problem in error and error.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["a.ply"]


def test_only_junk_leaves_nothing(tmp_path, capfd):
    splat = read_splat(TABLE).select(slice(0, 50))
    arrays = splat.arrays() | {"opacities": np.full(50, 0.01)}
    write_splat(tmp_path / "a.ply", type(splat)(**arrays))
    assert convert(tmp_path / "a.ply", tmp_path / "b.ply", "--clean") == 2
    assert "--clean: leaves no splats" in capfd.readouterr().err
