"""Files are paired as they were counted, and what has no pose is told."""

import json

import capture_writers as writers
import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.capture.formats import read_capture
from remosplat_drake.capture.readers.image_lists import in_natural_order

pytest.importorskip("PIL")


def test_two_comes_before_ten(tmp_path):
    names = ["10.png", "2.png", "1.png", "a2.png", "a10.png", "01-3.png"]
    paths = in_natural_order([tmp_path / name for name in names])
    assert [p.name for p in paths] == [
        "01-3.png",
        "1.png",
        "2.png",
        "10.png",
        "a2.png",
        "a10.png",
    ]


def test_unpadded_names_are_paired_right(scene_capture, tmp_path):
    writers.write_trajectory_log(tmp_path, scene_capture)
    for folder in ("color", "depth"):
        for file in sorted((tmp_path / folder).iterdir()):
            file.rename(file.with_name(f"{int(file.stem)}{file.suffix}"))
    again = read_capture(tmp_path, "trajectory-log")
    np.testing.assert_array_equal(again.rgb, scene_capture.rgb)
    np.testing.assert_allclose(again.depth, scene_capture.depth, atol=6e-4)
    assert again.names[2] == "frame 2 (2.png)"
    assert again.notes == ()


def shorter_log(folder):
    lines = (folder / "trajectory.log").read_text().splitlines()
    (folder / "trajectory.log").write_text("\n".join(lines[:15]))


def fewer_pose_files(folder):
    for i in (3, 4):
        (folder / f"frame-{i:06d}.pose.txt").unlink()


def shorter_lists(folder):
    lines = (folder / "groundtruth.txt").read_text().splitlines()
    (folder / "groundtruth.txt").write_text("\n".join(lines[:4]))


def fewer_frames(folder):
    document = json.loads((folder / "transforms.json").read_text())
    del document["frames"][3:]
    (folder / "transforms.json").write_text(json.dumps(document))


def fewer_poses(folder):
    metadata = json.loads((folder / "metadata.json").read_text())
    del metadata["poses"][3:]
    (folder / "metadata.json").write_text(json.dumps(metadata))


@pytest.mark.parametrize(
    ("name", "damage", "first"),
    [
        ("trajectory-log", shorter_log, "00003.png"),
        ("7-scenes", fewer_pose_files, "frame-000003.color.png"),
        ("tum", shorter_lists, "rgb/103.000000.png"),
        ("nerfstudio", fewer_frames, "images/0003.png"),
        ("record3d-export", fewer_poses, "rgb/3.jpg"),
    ],
)
def test_three_poses_for_five_images_are_told(
    scene_capture, tmp_path, name, damage, first
):
    pytest.importorskip("OpenEXR")
    writers.WRITERS[name](tmp_path, scene_capture.select(np.arange(5)))
    format_name = name.removesuffix("-export")
    assert read_capture(tmp_path, format_name).notes == ()
    damage(tmp_path)
    capture = read_capture(tmp_path, format_name)
    assert len(capture) == 3
    (note,) = capture.notes
    assert note.startswith("2 of 5 images lack ")
    assert note.endswith(first)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("depth_unit_scale_factor", 0),
        ("depth_unit_scale_factor", -1e-3),
        ("fl_x", 0),
        ("fl_y", 1e300),
        ("cx", 1e9),
        ("k1", 1e9),
        ("applied_scale", 0),
    ],
)
@pytest.mark.parametrize("inner", [False, True])
def test_every_number_has_its_range(
    scene_capture, tmp_path, field, value, inner
):
    writers.WRITERS["nerfstudio"](tmp_path, scene_capture.select([0, 1]))
    document = json.loads((tmp_path / "transforms.json").read_text())
    (document["frames"][1] if inner else document)[field] = value
    (tmp_path / "transforms.json").write_text(json.dumps(document))
    where = rf"frames\[1\]\.{field}" if inner else field
    with pytest.raises(FieldError, match=f"json: {where}: must be from"):
        read_capture(tmp_path)
