"""Messages of `reconstruct` about cameras that differ from their capture."""

import dataclasses as dc
import json
import shutil

import numpy as np
import pytest
from fisheye import fisheye_capture
from pydrake.math import RigidTransform

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.readers.nerfstudio import write_capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.commands.main import main
from remosplat_drake.reconstruction.report.quality_report import (
    read_report,
    report_path,
)
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.splat.formats import read_splat

pytest.importorskip("PIL")

QUICK = ["--device", "none", "--count", "500", "--up", "none"]


def reconstructed(tmp_path, capture: Capture, *flags: str):
    """The report of a quick reconstruction, and its page."""
    folder, output = tmp_path / "capture", tmp_path / "out" / "a.ply"
    write_capture(folder, capture)
    command = ["reconstruct", str(folder), "-o", str(output), *QUICK, *flags]
    assert main(command) == 0
    return read_report(output), output.with_suffix(".quality.html").read_text()


@pytest.fixture(scope="module")
def exact(scene_capture, tmp_path_factory):
    """The folder of a capture that is as it says, and of its splat."""
    folder = tmp_path_factory.mktemp("exact")
    reconstructed(folder, scene_capture)
    return folder


def with_focal(capture: Capture, factor: float) -> Capture:
    K = capture.K.copy()
    K[:, [0, 1], [0, 1]] *= factor
    return dc.replace(capture, K=K)


def test_a_short_focal_length_is_told_everywhere(
    scene_capture, tmp_path, capsys
):
    short = with_focal(scene_capture, 0.97)
    report, page = reconstructed(tmp_path, short)
    assert report.alignment is not None
    words = report.alignment.words
    assert "The focal length is 3." in words
    assert "longer than the capture says" in words
    assert words in capsys.readouterr().out
    (focal,) = [e for e in report.alignment.camera if e.name == "focal length"]
    assert focal.undone
    assert focal.value == pytest.approx(100 * (1 / 0.97 - 1), abs=0.5)
    assert "<h2>The camera</h2>" in page
    assert f">{focal}<" in page
    assert words not in report.trust


def test_a_report_of_an_older_version_has_no_list(exact, tmp_path):
    splat = shutil.copytree(exact, tmp_path, dirs_exist_ok=True) / "out/a.ply"
    document = json.loads(report_path(splat).read_text())
    assert document["alignment"].pop("camera")
    report_path(splat).write_text(json.dumps(document))
    report = read_report(splat)
    assert report.alignment is not None
    assert report.alignment.camera == []


def test_an_exact_camera_keeps_its_focal_length(
    scene_capture, tmp_path, capsys
):
    short = with_focal(scene_capture, 0.97)
    report, _ = reconstructed(tmp_path, short, "--camera", "exact")
    assert report.alignment is not None
    held = [e for e in report.alignment.camera if "depth " not in e.name]
    assert len(held) == 15
    assert not any(error.undone for error in held)
    assert max(error.deviation for error in held) < 1e-3
    assert "focal length" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (["--camera", "exakt"], "--camera: unknown choice 'exakt' (did you"),
        (["--depth-scale-std", "-1"], "--depth-scale-std: must be positive"),
        (
            ["--depth-scale-std", "2"],
            "--depth-scale-std: must be a fraction of",
        ),
        (["--depth-scale-std", "nan"], "--depth-scale-std: must be positive"),
    ],
)
def test_flags_out_of_range_are_one_line(flags, says, tmp_path, capsys):
    output = tmp_path / "a.ply"
    assert main(["reconstruct", "nowhere", "-o", str(output), *flags]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1


def test_colours_do_not_move_the_geometry(scene_capture, exact, tmp_path):
    """Exposure that jumps from frame to frame is none of depth's business."""
    gain = np.where(np.arange(len(scene_capture)) % 3 == 0, 0.4, 1.3)
    bright = scene_capture.rgb * gain[:, None, None, None]
    jumping = dc.replace(
        scene_capture, rgb=np.clip(bright, 0, 255).astype(np.uint8)
    )
    reconstructed(tmp_path, jumping)
    even, other = (read_splat(f / "out/a.ply") for f in (exact, tmp_path))
    np.testing.assert_array_equal(even.p_GK, other.p_GK)


def refused(tmp_path, capture: Capture, capsys) -> str:
    """The one line with which a capture is refused."""
    write_capture(tmp_path / "capture", capture)
    output = tmp_path / "out" / "a.ply"
    command = ["reconstruct", str(tmp_path / "capture"), "-o", str(output)]
    assert main([*command, *QUICK]) == 2
    assert not output.exists()
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    return error


def test_intrinsics_of_images_of_another_size_are_refused(
    scene_capture, tmp_path, capsys
):
    K = scene_capture.K.copy()
    K[:, :2] *= 2
    error = refused(tmp_path, dc.replace(scene_capture, K=K), capsys)
    assert "images about 2 times as large" in error
    assert "--accept intrinsics" in error


def test_focal_lengths_that_are_swapped_are_refused(
    scene_capture, tmp_path, capsys
):
    """Those of an image that was stretched, the wrong way round."""
    K = scene_capture.K.copy()
    K[:, 0, 0] *= 4 / 3
    error = refused(tmp_path, dc.replace(scene_capture, K=K), capsys)
    assert "correct f_x and f_y in the file" in error


CORNER = PrimitiveScene(
    boxes=tuple(
        Box(RigidTransform(p_WP), np.array(half))
        for p_WP, half in (
            ([0, 0, -0.05], [3, 3, 0.05]),
            ([2, 0, 1], [0.05, 3, 1]),
            ([0, 2, 1], [3, 0.05, 1]),
            ([0.8, 0.9, 0.3], [0.3, 0.4, 0.3]),
            ([1.2, -0.6, 0.5], [0.2, 0.3, 0.5]),
        )
    )
)


@pytest.mark.slow
def test_a_fisheye_lens_that_is_told_as_a_pinhole_is_doubtful(tmp_path, capsys):
    """Two coefficients do not describe it: 90 degrees from side to side."""
    poses = [
        look_at(
            np.array([1.6 * np.cos(a), 1.6 * np.sin(a), 1.2]),
            np.array([0.9, 0.7, 0.5]),
        )
        for a in np.linspace(np.pi - 0.3, 1.5 * np.pi + 0.3, 14)
    ]
    capture = fisheye_capture(CORNER, poses, (160, 120), np.deg2rad(45))
    report, _ = reconstructed(tmp_path, capture)
    (lens,) = [w for w in report.warnings if w.startswith("lens: ")]
    assert "the lens differs from that in the capture" in lens
    assert "k1 -0.3" in lens
    assert lens in report.trust
    assert not any(w.startswith("inexact") for w in report.warnings)
    # A splat that is measured anew is told to be as doubtful.
    splat, folder = tmp_path / "out" / "a.ply", tmp_path / "capture"
    assert main(["quality", str(splat), str(folder), "--points", "500"]) == 0
    assert read_report(splat).warnings == report.warnings
