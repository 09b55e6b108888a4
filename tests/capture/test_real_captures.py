"""Captures of real and of published cameras: neighbouring views agree."""

import numpy as np
import pytest

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.formats import detect_format, read_capture

pytest.importorskip("PIL")
pytestmark = pytest.mark.shared_data


def disagreement(capture: Capture, first: int, second: int) -> float:
    """Median difference of the depth that two views give each other [m].

    Points of the first are looked up in the second; what is more than 0.1 m
    behind or before the surface there is hidden from it, not wrong.
    """
    p_W = capture.points_W(first).reshape(-1, 3)
    X_CW = np.linalg.inv(capture.X_WC[second])
    p_C = p_W[np.isfinite(p_W[:, 0])] @ X_CW[:3, :3].T + X_CW[:3, 3]
    p_C = p_C[p_C[:, 2] > 0.1]
    uv = p_C @ capture.K[second].T
    column, row = np.floor(uv[:, :2] / uv[:, 2:]).astype(int).T
    height, width = capture.size
    inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
    there = capture.depth[second][row[inside], column[inside]]
    error = np.abs(there - p_C[inside, 2])[there > 0]
    assert len(error) > 0.2 * capture.depth[first].size
    return float(np.median(error[error < 0.1]))


def test_redkitchen(shared_data):
    folder = shared_data / "redkitchen" / "capture"
    assert detect_format(folder) == "7-scenes"
    capture = read_capture(folder, max_depth=4)
    assert len(capture) == 50 and capture.size == (480, 640)
    errors = [disagreement(capture, i, i + 1) for i in range(0, 10, 3)]
    assert np.median(errors) < 0.012 and max(errors) < 0.02


def test_redwood(shared_data):
    """Rendered, so the poses are exact; the depth has a sensor's noise."""
    folder = shared_data / "redwood5"
    assert detect_format(folder) == "trajectory-log"
    capture = read_capture(folder)
    assert len(capture) == 5
    # The principal point is the middle of the image.
    np.testing.assert_array_equal(capture.K[0, :2, 2], [320, 240])
    errors = [disagreement(capture, i, i + 1) for i in range(4)]
    assert max(errors) < 0.007


def test_tum_desk(shared_data, tmp_path):
    """Two frames without time stamps, put into a folder as TUM makes them."""
    source = shared_data / "tum_fr2_desk_pair"
    X_12 = np.loadtxt(source / "pose_2_in_1_icp.txt")
    folder = tmp_path / "rgbd_dataset_freiburg2_desk"
    folder.mkdir()
    lines = {"rgb": [], "depth": [], "groundtruth": []}
    from scipy.spatial.transform import Rotation

    for time, X in ((1, np.eye(4)), (2, X_12)):
        for kind, name in (("rgb", "color"), ("depth", "depth")):
            (folder / f"{name}_{time}.png").symlink_to(
                source / f"{name}_{time}.png"
            )
            lines[kind].append(f"{time}.0 {name}_{time}.png")
        q = Rotation.from_matrix(X[:3, :3]).as_quat()
        pose = " ".join(map(str, [*X[:3, 3], *q]))
        lines["groundtruth"].append(f"{time}.0 {pose}")
    for kind, text in lines.items():
        (folder / f"{kind}.txt").write_text("\n".join(text))
    (folder / "intrinsics.txt").symlink_to(source / "intrinsics.txt")
    capture = read_capture(folder)
    assert capture.size == (480, 640)
    assert 0.6 < (capture.depth > 0).mean() < 0.75
    assert disagreement(capture, 0, 1) < 0.006
    (folder / "intrinsics.txt").unlink()
    by_name = read_capture(folder)
    np.testing.assert_array_equal(by_name.K, capture.K)
    # That camera's lens is known too, and the images lose their margins.
    assert by_name.hidden is not None and 0 < by_name.hidden.mean() < 0.1
    assert disagreement(by_name, 0, 1) < 0.006
