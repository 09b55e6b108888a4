"""The images of a moving camera that a calibration keeps."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera import calibration_frames
from remosplat_drake.camera.calibration_frames import collect_still_frames
from remosplat_drake.capture.frames import Frame

DEGREES = [0, 0, 5, 5, 12, 20, 20, 20, 3, 3, 40, 40]
"""Where the camera has turned to in each image; it stands where one repeats."""


class TurningCamera:
    """A camera that turns from image to image."""

    def __init__(self):
        self._degrees = iter(DEGREES)

    def frame(self, q: np.ndarray, time: float) -> Frame:
        degrees = next(self._degrees)
        X_WC = np.eye(4)
        X_WC[:3, :3] = Rotation.from_euler("y", degrees, True).as_matrix()
        return Frame(
            name=str(degrees),
            K=np.array([[4.0, 0, 2], [0, 4, 2], [0, 0, 1]]),
            X_WC=X_WC,
            rgb=np.zeros((4, 4, 3), np.uint8),
            depth=np.ones((4, 4), np.float32),
        )


def angles(capture) -> list[float]:
    turns = Rotation.from_matrix(capture.X_WC[:, :3, :3]).magnitude()
    return np.rad2deg(turns).round(3).tolist()


def test_a_standing_camera_that_has_turned_enough_is_kept():
    capture = collect_still_frames(TurningCamera(), 3, lambda count: True)
    assert angles(capture) == [0, 20, 40]


def test_the_person_may_end_it_before():
    capture = collect_still_frames(TurningCamera(), 3, lambda count: count < 2)
    assert angles(capture) == [0, 20]


class FalteringCamera(TurningCamera):
    """A camera that is silent at every second image."""

    def __init__(self):
        super().__init__()
        self._asked = 0

    def frame(self, q: np.ndarray, time: float) -> Frame:
        self._asked += 1
        if self._asked % 2:
            raise RemoSplatError("the wrist camera sends no images")
        return super().frame(q, time)


def test_a_moment_of_silence_ends_nothing():
    capture = collect_still_frames(FalteringCamera(), 3, lambda count: True)
    assert angles(capture) == [0, 20, 40]


def test_a_camera_that_stays_silent_is_named(monkeypatch):
    monkeypatch.setattr(calibration_frames, "_SILENCE", 0.0)
    with pytest.raises(
        RemoSplatError, match="the wrist camera sends no images"
    ):
        collect_still_frames(FalteringCamera(), 3, lambda count: True)
