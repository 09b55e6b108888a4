"""`remosplat calibrate-hand-eye`, from a recorded folder to the scenario."""

import dataclasses as dc
import re

import numpy as np
import pytest
from runs import complaint

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.capture.readers.nerfstudio import write_capture
from remosplat_drake.commands.main import main

pytest.importorskip("cv2")
from rendered_board import BOARD, TRUTH, board_capture

TEXT = """# Our kitchen.
Kitchen:
  robot: {model: frankie}
  wrist_camera:
    # Taped on, about here.
    translation: [0.0, 0.0, 0.1]
    width: 640
    height: 480
  time_limit: 7  # [s]
"""
SPEC = f"{BOARD.columns}x{BOARD.rows}:{BOARD.square}:{BOARD.marker}"


@pytest.fixture(scope="module")
def folder(rendering, tmp_path_factory):
    """Images of the board, at the poses that the scenario's mount gives."""
    folder = tmp_path_factory.mktemp("calibration")
    file = folder / "kitchen.yaml"
    file.write_text(TEXT)
    camera = load_scenario(str(file)).camera
    assert camera is not None
    believed = camera.hand_eye().GetAsMatrix4()
    capture = board_capture()
    X_WC = capture.X_WC @ np.linalg.inv(TRUTH) @ believed
    write_capture(folder / "board", dc.replace(capture, X_WC=X_WC))
    return folder


def test_the_mount_is_found_and_written(folder, capsys, tmp_path):
    file = tmp_path / "kitchen.yaml"
    file.write_text(TEXT)
    line = ("calibrate-hand-eye", f"{file}:Kitchen", "--board", SPEC)
    capture = ("--capture", str(folder / "board"))
    assert main([*line, *capture]) == 0
    assert file.read_text() == TEXT
    assert main([*line, *capture, "--write"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"residual: 0\.\d+ pixels \(RMS\) over 12 images", said)
    camera = load_scenario(str(file)).camera
    assert camera is not None
    X = np.linalg.solve(TRUTH, camera.hand_eye().GetAsMatrix4())
    assert np.linalg.norm(X[:3, 3]) < 3e-4
    assert np.linalg.norm(X[:3, :3] - np.eye(3)) < 2e-3
    new = file.read_text().splitlines()
    kept = [text for text in TEXT.splitlines() if "translation" not in text]
    assert [text for text in new if text in kept] == kept


@pytest.mark.parametrize(
    ("flags", "mention"),
    [
        (
            ["TableReach", "--write"],
            "--write: shipped scenarios cannot be changed",
        ),
        (["TableReach", "--board", "big"], "expected COLUMNSxROWS"),
        (["TableReach", "--capture", "nowhere"], "nowhere: no such file"),
    ],
)
def test_mistakes_are_named(capsys, flags, mention):
    assert mention in complaint(capsys, "calibrate-hand-eye", *flags)


def test_another_board_is_not_found(folder, capsys):
    line = complaint(
        capsys,
        *("calibrate-hand-eye", str(folder / "kitchen.yaml")),
        *("--board", f"{SPEC}:DICT_6X6_50"),
        *("--capture", str(folder / "board")),
    )
    assert "only 0 images show the board; at least 5 are needed" in line
