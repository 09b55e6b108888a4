"""Captures written as other programs do are read back as they were."""

import dataclasses as dc
import json
import shutil

import capture_writers as writers
import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.formats import (
    FORMATS,
    ReadingConfig,
    detect_format,
    read_capture,
    read_keyframes,
)
from remosplat_drake.capture.motion import camera_velocities

pytest.importorskip("PIL")
pytest.importorskip("av")
pytest.importorskip("lzfse")
pytest.importorskip("OpenEXR")

DEPTH_TOLERANCE = {"instant-ngp": 10 / 65535, "record3d": 0}
COLOR_TOLERANCE = {"record3d": 40, "record3d-export": 40}
"""Its images are JPEG files; the others are exact."""


@pytest.fixture(scope="module")
def capture(scene_capture) -> Capture:
    """Four views whose depth is whole millimetres, as most files have it."""
    few = scene_capture.select(np.arange(4))
    depth = np.rint(few.depth.astype(float) * 1000) / 1000
    return dc.replace(few, depth=depth.astype(np.float32))


@pytest.fixture
def written(request, capture, tmp_path):
    """A capture in the format named by the test's parameter."""
    path = tmp_path / ("scan.r3d" if request.param == "record3d" else "scan")
    writers.WRITERS[request.param](path, capture)
    return request.param, path


every_format = pytest.mark.parametrize(
    "written", list(writers.WRITERS), indirect=True
)


@every_format
def test_reads_back_what_was_written(written, capture):
    name, path = written
    again = read_capture(path)
    np.testing.assert_allclose(again.K, capture.K, atol=1e-9)
    np.testing.assert_allclose(again.X_WC, capture.X_WC, atol=1e-9)
    error = np.abs(again.rgb.astype(int) - capture.rgb)
    assert error.max() <= COLOR_TOLERANCE.get(name, 0)
    assert error.mean() < 3
    step = DEPTH_TOLERANCE.get(name, 1e-6)
    np.testing.assert_allclose(again.depth, capture.depth, atol=step)
    assert again.hidden is None


@every_format
def test_tells_the_format_by_the_content(written):
    name, path = written
    aliases = {"instant-ngp": "nerfstudio", "record3d-export": "record3d"}
    assert detect_format(path) == aliases.get(name, name)


@every_format
def test_strides_over_frames(written, capture):
    _, path = written
    again = read_capture(path, stride=3)
    np.testing.assert_allclose(again.X_WC, capture.X_WC[[0, 3]], atol=1e-9)
    assert np.abs(again.rgb.astype(int) - capture.rgb[[0, 3]]).mean() < 3
    np.testing.assert_allclose(again.depth, capture.depth[[0, 3]], atol=2e-4)


def test_an_unpacked_archive_reads_like_the_archive(capture, tmp_path):
    writers.write_record3d(tmp_path / "a.r3d", capture)
    shutil.unpack_archive(tmp_path / "a.r3d", tmp_path / "a", "zip")
    packed = read_capture(tmp_path / "a.r3d")
    unpacked = read_capture(tmp_path / "a")
    np.testing.assert_array_equal(packed.rgb, unpacked.rgb)
    np.testing.assert_array_equal(packed.depth, unpacked.depth)


def test_knows_older_stray_scanner_folders(capture, tmp_path):
    """They have one camera, and at times arrays in place of images."""
    writers.write_stray_scanner(tmp_path, capture, per_frame_cameras=False)
    for i, depth in enumerate(capture.depth):
        (tmp_path / f"depth/{i:06d}.png").unlink()
        steps = np.rint(depth * 1000).astype(np.uint16)
        np.save(tmp_path / f"depth/{i:06d}.npy", steps)
    again = read_capture(tmp_path)
    np.testing.assert_allclose(again.K, capture.K)
    np.testing.assert_allclose(again.depth, capture.depth, atol=1e-6)


@pytest.mark.parametrize("name", ["record3d", "stray-scanner"])
def test_coarse_depth_sets_the_size(name, capture, tmp_path):
    """A pixel of depth is two of colour wide, and sees what they see."""
    path = tmp_path / "scan.r3d"
    confidence = np.full((45, 60), 2)
    confidence[:20] = [[1]]
    if name == "record3d":
        members = writers.record3d_members(capture, confidence, shrink=2)
        writers.write_archive(path, members)
    else:
        writers.write_stray_scanner(path, capture, confidence, shrink=2)
    again = read_capture(path)
    assert again.size == (45, 60)
    np.testing.assert_allclose(again.K[:, :2], capture.K[:, :2] / 2)
    blocks = capture.rgb.reshape(4, 45, 2, 60, 2, 3).mean(axis=(2, 4))
    assert np.abs(again.rgb - blocks).mean() < 3
    assert (again.depth[:, :20] == 0).all()
    np.testing.assert_allclose(
        again.depth[:, 20:], capture.depth[:, 40::2, ::2], atol=1e-6
    )


def test_options_bound_depth_and_size(capture, tmp_path):
    writers.write_seven_scenes(tmp_path, capture)
    again = read_capture(tmp_path, max_depth=1.5, max_size=40)
    assert again.size == (30, 40)
    assert 1.4 < again.depth.max() <= 1.5
    np.testing.assert_allclose(again.K[:, :2], capture.K[:, :2] / 3)
    # The middle one of three pixels has the same centre as the large one.
    picked = capture.depth[:, 1::3, 1::3]
    np.testing.assert_allclose(
        again.depth, np.where(picked > 1.5, 0, picked), atol=1e-6
    )
    near = again.depth[0] > 0
    np.testing.assert_allclose(
        again.points_W(0)[near], capture.points_W(0)[1::3, 1::3][near]
    )


def test_names_what_it_looks_for(tmp_path):
    with pytest.raises(
        FileError, match=r"no capture of a known format.*transforms\.json"
    ):
        read_capture(tmp_path)
    with pytest.raises(FileError, match="no such file or folder"):
        read_capture(tmp_path / "absent")


def test_names_the_valid_formats(capture, tmp_path):
    writers.write_tum(tmp_path, capture)
    with pytest.raises(FieldError, match=r"did you mean 'tum'.*7-scenes"):
        read_capture(tmp_path, "tumm")
    with pytest.raises(FileError, match=r"transforms\.json"):
        read_capture(tmp_path, "nerfstudio")
    assert set(FORMATS) <= set(writers.WRITERS)


@pytest.mark.parametrize("name", ["stride", "max_depth", "max_size"])
def test_refuses_senseless_options(name):
    with pytest.raises(FieldError, match=f"{name}: must be positive"):
        ReadingConfig(**{name: 0})


def copies(capture: Capture, count: int) -> Capture:
    """Each view of a capture so many times, one after the other."""
    return capture.select(np.repeat(np.arange(len(capture)), count))


@every_format
def test_keyframes_are_read_as_they_are(written, capture):
    """Of four views three, whichever; none of them differs from the file's."""
    _, path = written
    every = read_capture(path)
    few, keyframes = read_keyframes(path, None, ReadingConfig(keyframes=3))
    assert keyframes is not None and len(few) == len(keyframes.chosen) == 3
    expected = every.select(keyframes.chosen)
    np.testing.assert_array_equal(few.X_WC, expected.X_WC)
    np.testing.assert_array_equal(few.rgb, expected.rgb)
    np.testing.assert_array_equal(few.depth, expected.depth)
    assert few.names == expected.names
    # As many as there are need no choice.
    assert read_keyframes(path, None, ReadingConfig(keyframes=4))[1] is None


@pytest.mark.parametrize("name", list(writers.WRITERS))
def test_keyframes_leave_out_what_shows_the_same(name, capture, tmp_path):
    path = tmp_path / ("scan.r3d" if name == "record3d" else "scan")
    writers.WRITERS[name](path, copies(capture, 3))
    config = ReadingConfig(keyframes=6)
    few, keyframes = read_keyframes(path, None, config)
    assert keyframes is not None and keyframes.missed == 0
    assert {i // 3 for i in keyframes.chosen.tolist()} == set(range(4))
    expected = capture.X_WC[keyframes.chosen // 3]
    np.testing.assert_allclose(few.X_WC, expected, atol=1e-9)
    # Among every fourth one there is one of each view.
    few, keyframes = read_keyframes(path, None, ReadingConfig(4, 2))
    assert keyframes is not None and keyframes.frames == 3


TIMED = {
    "stray-scanner": lambda path: None,
    "record3d": lambda path: None,
    "record3d-export": lambda path: None,
    "nerfstudio": lambda path: add_times(path),
    "tum": lambda path: hurry(path),
}
"""Formats that tell times, and what makes a writer's frames follow soon."""


def add_times(folder):
    """What NeRFCapture writes."""
    path = folder / "transforms.json"
    document = json.loads(path.read_text())
    for i, frame in enumerate(document["frames"]):
        frame["timestamp"] = 1e4 + i / 60
    path.write_text(json.dumps(document))


def hurry(folder):
    """Frames of a second become those of a sixtieth."""
    for name in ("rgb", "depth", "groundtruth"):
        path = folder / f"{name}.txt"
        rows = [line.split() for line in path.read_text().splitlines()[1:]]
        lines = [
            f"{float(time) / 60!r} {' '.join(rest)}" for time, *rest in rows
        ]
        path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("name", list(writers.WRITERS))
def test_velocities_come_from_the_poses_of_all_frames(name, capture, tmp_path):
    """At 60 frames a second; those of keyframes are not between keyframes."""
    path = tmp_path / ("scan.r3d" if name == "record3d" else "scan")
    writers.WRITERS[name](path, capture)
    if name not in TIMED:
        assert read_capture(path).velocity_W is None
        return
    TIMED[name](path)
    times = np.arange(4) / 60
    expected = camera_velocities(times, capture.X_WC)
    again = read_capture(path, stride=2)
    assert again.velocity_W is not None
    np.testing.assert_allclose(again.velocity_W, expected[[0, 2]], rtol=1e-6)


def test_a_video_that_stops_early_is_used_to_its_end(capture, tmp_path):
    """Frames that only the odometry has are not chosen."""
    writers.write_stray_scanner(tmp_path, copies(capture, 2))
    writers.write_video(tmp_path / "rgb.mp4", copies(capture, 2).rgb[:5])
    assert len(read_capture(tmp_path)) == 5
    few, keyframes = read_keyframes(tmp_path, None, ReadingConfig(keyframes=3))
    assert keyframes is not None and keyframes.frames == 5
    assert len(few) == 3
