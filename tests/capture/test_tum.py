"""TUM's lists: times that belong together, poses between poses, cameras."""

import capture_writers as writers
import numpy as np
import pytest

from remosplat_drake.base.errors import FileError
from remosplat_drake.capture.formats import read_capture
from remosplat_drake.capture.readers.tum import associate, interpolate_poses

pytest.importorskip("PIL")


def test_nearest_times_by_hand():
    times = np.array([0.0, 1.0, 2.0, 3.0])
    others = np.array([0.01, 0.995, 1.002, 2.5])
    np.testing.assert_array_equal(associate(times, others), [0, 2, -1, -1])
    np.testing.assert_array_equal(associate(times, others[:1]), [0, -1, -1, -1])


def test_pose_between_two_by_hand():
    """Half way between no turn and a half turn about z is a quarter turn."""
    times = np.array([10.0, 12.0])
    poses = np.array([[0, 0, 0, 0, 0, 0, 1], [2, 4, 6, 0, 0, 1, 0.0]])
    X_WC = interpolate_poses(times, poses, np.array([11.0]))[0]
    np.testing.assert_allclose(X_WC[:3, 3], [1, 2, 3])
    # Either way round is half of a half turn.
    np.testing.assert_allclose(
        np.abs(X_WC[:2, :2]), [[0, 1], [1, 0]], atol=1e-9
    )
    after = interpolate_poses(times, poses, np.array([99.0]))[0]
    np.testing.assert_allclose(after[:3, 3], [2, 4, 6])


def test_leaves_out_frames_without_depth_or_pose(scene_capture, tmp_path):
    writers.write_tum(tmp_path, scene_capture.select(np.arange(5)))
    for name, line in (("depth", 1), ("groundtruth", 3)):
        path = tmp_path / f"{name}.txt"
        lines = path.read_text().splitlines()
        # The first line is a comment.
        path.write_text("\n".join(lines[: line + 1] + lines[line + 2 :]))
    again = read_capture(tmp_path)
    expected = scene_capture.X_WC[[0, 2, 4]]
    np.testing.assert_allclose(again.X_WC, expected, atol=1e-9)


def test_knows_the_benchmarks_cameras(scene_capture, tmp_path):
    folder = tmp_path / "rgbd_dataset_freiburg3_desk"
    writers.write_tum(folder, scene_capture.select(np.arange(2)))
    (folder / "intrinsics.txt").unlink()
    again = read_capture(folder)
    assert again.K[0, 0, 0] == 535.4
    assert again.K[0, 0, 2] == 320.6
    with pytest.raises(FileError, match="no intrinsics"):
        read_capture(folder.rename(tmp_path / "desk"))
