"""A camera that sees what moves, in the room or on the robot."""

import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.detection.detection_camera_config import (
    DetectionCameraConfig,
)


def test_a_camera_in_the_room_stays_where_it_is(frankie):
    camera = DetectionCameraConfig(
        name="hall", translation=[0, 0, 2], look_at=[1, 0, 2]
    )
    pose = camera.pose(frankie)
    home, elsewhere = frankie.q_home, frankie.q_home + 0.3
    np.testing.assert_allclose(pose(home), pose(elsewhere))
    np.testing.assert_allclose(pose(home)[:3, 2], [1, 0, 0], atol=1e-12)


def test_a_camera_on_a_frame_that_does_not_exist_is_named(frankie):
    camera = DetectionCameraConfig(
        name="hall", translation=[0, 0, 2], frame="panda_hnad"
    )
    with pytest.raises(FieldError, match=r"hall: frame: .*'panda_hand'"):
        camera.pose(frankie)
