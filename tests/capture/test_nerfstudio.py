"""Captures as nerfstudio folders, and points from their depth."""

import dataclasses as dc
import json
import re

import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError, FileError, RemoSplatError
from remosplat_drake.capture.capture import Capture, back_project
from remosplat_drake.capture.formats import read_capture
from remosplat_drake.capture.readers.nerfstudio import write_capture

Image = pytest.importorskip("PIL.Image")


@pytest.fixture
def capture() -> Capture:
    rng = np.random.default_rng(0)
    X_WC = np.tile(np.eye(4), (2, 1, 1))
    X_WC[1, :3, 3] = [1, 2, 3]
    return Capture(
        K=np.tile([[10.0, 0, 4], [0, 11, 3], [0, 0, 1]], (2, 1, 1)),
        X_WC=X_WC,
        rgb=rng.integers(0, 256, (2, 6, 8, 3), np.uint8),
        depth=(rng.integers(0, 5000, (2, 6, 8)) / 1000).astype(np.float32),
    )


def edit(folder, change):
    """Changes the document of a folder."""
    path = folder / "transforms.json"
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))


def test_round_trip(capture, tmp_path):
    write_capture(tmp_path, capture)
    again = read_capture(tmp_path)
    np.testing.assert_array_equal(again.rgb, capture.rgb)
    np.testing.assert_array_equal(again.depth, capture.depth)
    np.testing.assert_array_equal(again.X_WC, capture.X_WC)
    np.testing.assert_array_equal(again.K, capture.K)


def test_round_trip_of_masks_and_a_camera_per_view(capture, tmp_path):
    K = capture.K.copy()
    K[1, 0] = [12, 0, 4.5]
    hidden = np.random.default_rng(1).random(capture.depth.shape) < 0.3
    masked = dc.replace(capture, K=K, hidden=hidden)
    write_capture(tmp_path, masked)
    again = read_capture(tmp_path / "transforms.json")
    np.testing.assert_array_equal(again.K, K)
    np.testing.assert_array_equal(again.hidden, hidden)
    np.testing.assert_array_equal(again.depth, masked.depth)


def test_an_interrupted_capture_is_none(capture, tmp_path, monkeypatch):
    """Neither a new one nor an older one whose images are half replaced."""
    write_capture(tmp_path, capture)

    def interrupt(image, *arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(Image.Image, "save", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_capture(tmp_path, capture)
    with pytest.raises(FileError):
        read_capture(tmp_path)


def test_depth_too_large_for_the_file_is_unknown(capture, tmp_path):
    depth = capture.depth.copy()
    depth[0, 0, :2] = [65.535, 65.6]
    write_capture(tmp_path, dc.replace(capture, depth=depth))
    again = read_capture(tmp_path)
    np.testing.assert_allclose(again.depth[0, 0, :2], [65.535, 0])


@pytest.mark.parametrize("suffix", [".npy", ".tiff"])
def test_reads_float_depth(capture, tmp_path, suffix):
    """Not finite is unknown; the unit counts as for whole numbers."""
    write_capture(tmp_path, capture)
    metres = np.where(capture.depth == 0, np.nan, capture.depth)
    name = f"depth/float{suffix}"
    if suffix == ".npy":
        np.save(tmp_path / name, metres[0])
    else:
        Image.fromarray(metres[0]).save(tmp_path / name)
    edit(tmp_path, lambda d: d.update(depth_unit_scale_factor=1))
    edit(tmp_path, lambda d: d["frames"][0].update(depth_file_path=name))
    edit(tmp_path, lambda d: d["frames"].pop())
    again = read_capture(tmp_path)
    np.testing.assert_array_equal(again.depth[0], capture.depth[0])


def test_camera_from_the_angle_of_view(capture, tmp_path):
    """Half the width, 4 pixels, at tan 45 degrees."""
    write_capture(tmp_path, capture)
    for key in ("fl_x", "fl_y", "cx", "cy", "w", "h"):
        edit(tmp_path, lambda d, key=key: d.pop(key))
    edit(tmp_path, lambda d: d.update(camera_angle_x=np.pi / 2))
    K = read_capture(tmp_path).K[0]
    np.testing.assert_allclose(K, [[4, 0, 4], [0, 4, 3], [0, 0, 1]])


def test_camera_of_larger_images_is_scaled(capture, tmp_path):
    write_capture(tmp_path, capture)
    edit(tmp_path, lambda d: d.update(w=16, h=12))
    K = read_capture(tmp_path).K
    np.testing.assert_allclose(K[:, :2], capture.K[:, :2] / 2)


@pytest.mark.parametrize(
    ("field", "value", "problem"),
    [
        ("w", 10**30, "the image must have 1 to"),
        ("h", 1e308, "the image must have 1 to"),
        ("w", 0.5, "the image must have 1 to"),
        ("fl_x", 10**30, None),
        ("fl_x", int("1" * 4000), "fl_x: expected a number, got inf"),
        ("cx", 1e308, None),
        ("k1", 1e308, "k1: must be from -1000000 to 1000000"),
        ("k4", -1e308, "k4: must be from"),
        ("applied_scale", 1e-320, None),
        ("applied_scale", 10**30, None),
        ("depth_unit_scale_factor", 1e308, "must be from"),
        ("depth_unit_scale_factor", -1e-3, "must be from"),
        ("frames", [[[]]], r"frames\[0\]: expected an object"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_numbers_beyond_all_measure(capture, tmp_path, field, value, problem):
    """One line; or they are read, where they do no harm."""
    write_capture(tmp_path, capture)
    edit(tmp_path, lambda d: d.update({field: value}))
    try:
        read_capture(tmp_path)
        message = None
    except RemoSplatError as error:
        message = str(error)
        assert "\n" not in message
    if problem is not None:
        assert message is not None
        assert re.search(problem, message)


@pytest.mark.filterwarnings("error")
def test_angles_of_view_that_no_camera_has(capture, tmp_path):
    write_capture(tmp_path, capture)
    edit(tmp_path, lambda d: [d.pop(key) for key in ("fl_x", "fl_y")])
    for angle in (0, np.pi, -1, 1e308):
        edit(tmp_path, lambda d, a=angle: d.update(camera_angle_x=a))
        with pytest.raises(FieldError, match="camera_angle_x: must be between"):
            read_capture(tmp_path)


def test_undoes_the_scale_of_the_world(capture, tmp_path):
    write_capture(tmp_path, capture)
    turn = [[0, 1, 0, 5], [1, 0, 0, 0], [0, 0, -1, 0]]
    edit(
        tmp_path, lambda d: d.update(applied_scale=0.5, applied_transform=turn)
    )
    again = read_capture(tmp_path)
    np.testing.assert_array_equal(again.X_WC[1, :3, 3], [2, 4, 6])


def test_removes_the_distortion(capture, tmp_path):
    """A flat wall stays one; corners that the lens did not show are hidden."""
    depth = np.full_like(capture.depth, 2)
    write_capture(tmp_path, dc.replace(capture, depth=depth))
    edit(tmp_path, lambda d: d.update(k1=3))
    again = read_capture(tmp_path)
    assert again.hidden is not None
    assert 0 < again.hidden.mean() < 0.6
    assert (again.depth[~again.hidden] == 2).all()


def test_file_has_opengl_cameras(capture, tmp_path):
    write_capture(tmp_path, capture)
    document = json.loads((tmp_path / "transforms.json").read_text())
    X_WC_gl = np.array(document["frames"][0]["transform_matrix"])
    np.testing.assert_allclose(X_WC_gl, np.diag([1, -1, -1, 1]))


def test_back_projection_by_hand():
    K = np.array([[2.0, 0, 1], [0, 2, 0.5], [0, 0, 1]])
    X_WC = np.eye(4)
    X_WC[:3, 3] = [0, 0, 10]
    points = back_project(K, np.array([[4.0, 0.0]]), X_WC)
    np.testing.assert_allclose(points[0, 0], [-1, 0, 14])
    assert np.isnan(points[0, 1]).all()


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda d: d.pop("fl_x"), "fl_x"),
        (lambda d: d.update(frames=[]), "frames"),
        (lambda d: d.update(frames=[3]), r"frames\[0\]: expected an object"),
        (lambda d: d["frames"][1].pop("depth_file_path"), r"frames\[1\]\.dep"),
        (lambda d: d["frames"][1].update(cx="a"), r"frames\[1\]\.cx"),
        (
            lambda d: d["frames"][0].update(transform_matrix=[[1]]),
            r"frames\[0\]\.transform_matrix",
        ),
        (
            lambda d: d["frames"][1]["transform_matrix"][0].__setitem__(
                0, float("nan")
            ),
            r"frames\[1\]\.transform_matrix: .*finite",
        ),
        (
            lambda d: d.update(camera_model="OPENCV_FISHEYE"),
            "unknown camera model 'OPENCV_FISHEYE'.*PINHOLE",
        ),
        (lambda d: d.update(is_fisheye=True), "unknown camera model"),
        (lambda d: d.update(applied_scale=0), "applied_scale"),
        (
            lambda d: d.update(applied_transform=np.eye(4).tolist()[:2]),
            "applied_transform",
        ),
        (
            lambda d: d.update(applied_transform=(2 * np.eye(4)).tolist()),
            "applied_transform: .*metric",
        ),
        (lambda d: d.update(w=0), "w, h: the image must have 1"),
        (
            lambda d: d["frames"][0].update(
                depth_path=d["frames"][0].pop("depth_file_path")
            ),
            "integer_depth_scale: expected a number",
        ),
    ],
)
def test_names_the_bad_field(capture, tmp_path, change, match):
    write_capture(tmp_path, capture)
    edit(tmp_path, change)
    with pytest.raises(FieldError, match=match):
        read_capture(tmp_path)


def test_names_a_missing_image(capture, tmp_path):
    write_capture(tmp_path, capture)
    (tmp_path / "depth" / "0001.png").unlink()
    with pytest.raises(FileError, match=r"0001\.png"):
        read_capture(tmp_path)


def test_names_a_missing_folder(tmp_path):
    with pytest.raises(FileError, match=r"transforms\.json"):
        read_capture(tmp_path)


def test_names_an_image_of_another_shape(capture, tmp_path):
    write_capture(tmp_path, capture)
    edit(tmp_path, lambda d: d.update(w=8, h=8))
    with pytest.raises(FileError, match=r"8x8.*8x6"):
        read_capture(tmp_path)
