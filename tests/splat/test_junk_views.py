"""Cameras of a training: what they look at, and files that tell them."""

import json

import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.splat.cleaning.views import read_views

POSE = np.eye(4).tolist()
CAMERA = {"w": 200, "h": 100, "fl_x": 100.0}


def saved(tmp_path, frames, **document):
    path = tmp_path / "transforms.json"
    path.write_text(json.dumps({**document, "frames": frames}))
    return path


def test_a_camera_looks_along_its_negative_z(tmp_path):
    views = read_views(saved(tmp_path, [{"transform_matrix": POSE}], **CAMERA))
    # At 2 m the image is 4 m wide and 2 m high.
    points = np.array(
        [[0, 0, -2], [1.9, 0, -2], [2.1, 0, -2], [0, 1.1, -2], [0, 0, 2.0]]
    )
    seen, before = views.look(points, points)
    assert seen.tolist() == [True, True, False, False, False]
    assert not before.any()
    assert views.seen_share(points) == 0.4


def test_what_is_near_is_a_tenth_of_the_scene_s_depth(tmp_path):
    views = read_views(saved(tmp_path, [{"transform_matrix": POSE}], **CAMERA))
    scene = np.array([[0, 0, -4.0], [0.1, 0, -4], [0, 0.1, -4], [0, 9, 0]])
    points = np.array([[0, 0, -0.39], [0, 0, -0.41], [0, 0, 0.39]])
    _, before = views.look(points, scene)
    assert before.tolist() == [True, False, False]


def test_a_frame_s_own_camera_goes_before_the_document_s(tmp_path):
    frames = [
        {"transform_matrix": POSE},
        {"transform_matrix": POSE, "fl_x": 50.0, "fl_y": 60.0, "cx": 7.0},
    ]
    views = read_views(saved(tmp_path, frames, **CAMERA))
    assert views.K[0].tolist() == [[100, 0, 100], [0, 100, 50], [0, 0, 1]]
    assert views.K[1].tolist() == [[50, 0, 7], [0, 60, 50], [0, 0, 1]]


def test_an_angle_tells_the_focal_length(tmp_path):
    frames = [{"transform_matrix": POSE}]
    path = saved(tmp_path, frames, w=200, h=100, camera_angle_x=np.pi / 2)
    assert read_views(path).K[0, 0, 0] == pytest.approx(100)


@pytest.mark.parametrize(
    ("frames", "document", "field"),
    [
        ([], CAMERA, "frames"),
        ([3], CAMERA, r"frames\[0\]"),
        ([{}], CAMERA, r"frames\[0\].transform_matrix"),
        ([{"transform_matrix": [[1]]}], CAMERA, "transform_matrix"),
        ([{"transform_matrix": (2 * np.eye(4)).tolist()}], CAMERA, "rotation"),
        ([{"transform_matrix": POSE}], {"w": 2, "h": 1}, "camera_angle_x"),
        ([{"transform_matrix": POSE}], CAMERA | {"w": 0}, "w: must lie"),
        ([{"transform_matrix": POSE, "cx": "x"}], CAMERA, r"frames\[0\].cx"),
    ],
)
def test_bad_fields_are_named(tmp_path, frames, document, field):
    with pytest.raises(FieldError, match=field) as error:
        read_views(saved(tmp_path, frames, **document))
    assert "\n" not in str(error.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileError, match=r"no\.json"):
        read_views(tmp_path / "no.json")
