"""Captures: the folder they are kept in, and points from their depth."""

import json

import numpy as np
import pytest

from remosplat_drake.capture.capture import Capture, back_project
from remosplat_drake.capture.formats import read_capture
from remosplat_drake.capture.nerfstudio import write_capture
from remosplat_drake.errors import FieldError, FileError

pytest.importorskip("PIL")


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


def test_round_trip(capture, tmp_path):
    write_capture(tmp_path, capture)
    again = read_capture(tmp_path)
    np.testing.assert_array_equal(again.rgb, capture.rgb)
    np.testing.assert_allclose(again.depth, capture.depth, atol=1e-6)
    np.testing.assert_allclose(again.X_WC, capture.X_WC)
    np.testing.assert_allclose(again.K, capture.K)


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
    ("edit", "match"),
    [
        (lambda d: d.pop("fl_x"), "fl_x"),
        (lambda d: d.update(frames=[]), "frames"),
        (lambda d: d["frames"][1].pop("depth_file_path"), r"frames\[1\]\.dep"),
        (
            lambda d: d["frames"][0].update(transform_matrix=[[1]]),
            r"frames\[0\]\.transform_matrix",
        ),
    ],
)
def test_names_the_bad_field(capture, tmp_path, edit, match):
    write_capture(tmp_path, capture)
    path = tmp_path / "transforms.json"
    document = json.loads(path.read_text())
    edit(document)
    path.write_text(json.dumps(document))
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
