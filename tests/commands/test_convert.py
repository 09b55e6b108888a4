"""`remosplat convert`: its output, its messages and its errors."""

import numpy as np
import pytest
from optional import needs_torch

from remosplat_drake.commands.main import main
from remosplat_drake.splat.formats import read_splat, write_splat
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def toy(scales: int) -> GaussianSplat:
    """Five splats on the x axis, a metre apart, shortest along y."""
    return GaussianSplat(
        p_GK=np.arange(5.0)[:, None] * [1, 0, 0],
        quaternions=np.tile([1.0, 0, 0, 0], (5, 1)),
        scales=np.tile([0.1, 0.01, 0.2], (5, 1))[:, :scales],
        opacities=np.full(5, 0.6),
        colors=np.full((5, 3), 0.2),
    )


@pytest.fixture
def discs(tmp_path):
    write_splat(tmp_path / "discs.ply", toy(2))
    return tmp_path / "discs.ply"


def convert(*arguments) -> int:
    return main(["convert", *map(str, arguments)])


def test_says_what_a_lossy_format_lost(discs, capfd):
    output = discs.parent / "new" / "discs.spz"
    assert convert(discs, output) == 0
    said = capfd.readouterr().out
    assert f"{discs}: PLY, 5 2DGS discs, colours of degree 0" in said
    assert "ellipsoids 45 um thick" in said
    assert "Lossy. Positions have steps of 0.24 mm" in said
    # ln 0.1 = -2.3026 is stored as -37 / 16 = -2.3125: 1 %; ln 0.01 as
    # -74 / 16 = -4.625 instead of -4.6052: 2 %. 0.6 is 153 / 255.
    assert "median and largest: position 0 and 0 mm; scale 2 and 2 %" in said
    assert said.rstrip().endswith("opacity 0 and 0")
    assert read_splat(output).is_surfel


@needs_torch
def test_an_exact_format_has_nothing_to_say(discs, capfd):
    assert convert(discs, discs.parent / "discs.pt") == 0
    said = capfd.readouterr().out
    assert "Lossy" not in said
    assert convert(discs.parent / "discs.pt", discs.parent / "again.ply") == 0
    again = read_splat(discs.parent / "again.ply")
    np.testing.assert_allclose(again.scales, toy(2).scales, rtol=1e-6)


def test_says_where_uncertainty_is_lost(discs, capfd):
    write_splat(discs, toy(2).with_uncertainty([0.0, 0.01, 0.02, 0.0, 0.0]))
    assert convert(discs, discs.parent / "again.ply") == 0
    said = capfd.readouterr().out
    assert said.count("uncertain by up to 20.0 mm") == 2
    assert "lost" not in said
    assert convert(discs, discs.parent / "discs.splat") == 0
    said = capfd.readouterr().out
    assert "uncertainty, up to 20.0 mm, is lost: .splat cannot store" in said
    assert read_splat(discs.parent / "discs.splat").uncertainty is None


def test_flattens_and_crops(tmp_path):
    write_splat(tmp_path / "a.ply", toy(3))
    crop = ["--crop", "0.5", "-1", "-1", "3", "1", "1"]
    assert convert(tmp_path / "a.ply", tmp_path / "b.ply", *crop) == 0
    assert read_splat(tmp_path / "b.ply").scales.shape == (3, 3)
    output = tmp_path / "c.compressed.ply"
    assert convert(tmp_path / "a.ply", output, "--surfels") == 0
    splat = read_splat(output)
    assert splat.is_surfel
    normal = np.abs(splat.R_GK[0, :, 2])
    np.testing.assert_allclose(normal, [0, 1, 0], atol=2e-3)


@needs_torch
def test_a_checkpoint_s_model_may_be_told(tmp_path, capfd):
    write_splat(tmp_path / "a.pt", toy(3))
    assert convert(tmp_path / "a.pt", tmp_path / "a.ply") == 2
    assert "--model 2dgs" in capfd.readouterr().err
    model = ["--model", "2dgs"]
    assert convert(tmp_path / "a.pt", tmp_path / "a.ply", *model) == 0
    assert read_splat(tmp_path / "a.ply").is_surfel


@pytest.mark.parametrize(
    ("source", "output", "flags", "problem"),
    [
        ("discs.ply", "b.obj", [], "b.obj: unknown suffix"),
        ("nowhere.ply", "b.ply", [], "nowhere.ply: no such file"),
        ("bad.spz", "b.ply", [], "bad.spz: not an SPZ"),
        ("discs.ply", ".", [], "unknown suffix"),
        ("discs.ply", "discs.ply/b.ply", [], "b.ply: "),
        (
            "discs.ply",
            "b.ply",
            ["--crop", "7", "7", "7", "8", "8", "8"],
            "no splats",
        ),
    ],
)
def test_mistakes(discs, capfd, source, output, flags, problem):
    folder = discs.parent
    (folder / "bad.spz").write_bytes(b"bad")
    assert convert(folder / source, folder / output, *flags) == 2
    captured = capfd.readouterr()
    assert problem in captured.err
    assert captured.err.count("\n") == 1
    assert sorted(p.name for p in folder.iterdir()) == ["bad.spz", "discs.ply"]
