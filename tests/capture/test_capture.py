"""`Capture`: its views, selected and in another frame."""

import dataclasses as dc

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture

VIEWS = 4


@pytest.fixture
def capture() -> Capture:
    """Four views of 2 x 3 pixels, whose cameras move."""
    shape = (VIEWS, 2, 3)
    return Capture(
        K=np.tile(np.eye(3), (VIEWS, 1, 1)),
        X_WC=np.tile(np.eye(4), (VIEWS, 1, 1)),
        rgb=np.zeros((*shape, 3), np.uint8),
        depth=np.ones(shape, np.float32),
        up_W=(0.0, 0.0, 1.0),
        velocity_W=np.arange(6.0 * VIEWS).reshape(VIEWS, 6),
        acceleration_W=100 + np.arange(6.0 * VIEWS).reshape(VIEWS, 6),
    )


@pytest.mark.parametrize("name", ["velocity_W", "acceleration_W"])
def test_selected_views_keep_their_motions(capture, name):
    whole = getattr(capture, name)
    by_index = capture.select(np.array([3, 1]))
    np.testing.assert_array_equal(getattr(by_index, name), whole[[3, 1]])
    by_mask = capture.select(np.array([False, True, True, False]))
    np.testing.assert_array_equal(getattr(by_mask, name), whole[1:3])


def test_in_another_frame_motions_turn_and_do_not_shift(capture):
    """A quarter turn about z: x becomes y and y becomes -x."""
    X_FW = np.eye(4)
    X_FW[:3, :3] = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    X_FW[:3, 3] = [5, 6, 7]
    turned = capture.expressed_in(X_FW)
    np.testing.assert_allclose(
        turned.velocity_W[0], [-1, 0, 2, -4, 3, 5], atol=1e-12
    )
    np.testing.assert_allclose(
        turned.acceleration_W[0], [-101, 100, 102, -104, 103, 105]
    )
    np.testing.assert_allclose(turned.up_W, [0, 0, 1])
    np.testing.assert_allclose(turned.X_WC[:, :3, 3], [[5, 6, 7]] * VIEWS)


def test_unknown_motions_stay_unknown(capture):
    still = dc.replace(capture, velocity_W=None, acceleration_W=None, up_W=None)
    for other in (still.select(np.arange(2)), still.expressed_in(np.eye(4))):
        assert other.velocity_W is None
        assert other.acceleration_W is None
        assert other.up_W is None


@pytest.mark.parametrize("name", ["velocity_W", "acceleration_W"])
@pytest.mark.parametrize("shape", [(VIEWS, 3), (VIEWS - 1, 6), (6,)])
def test_motions_of_another_shape_are_refused(capture, name, shape):
    with pytest.raises(RemoSplatError) as caught:
        dc.replace(capture, **{name: np.zeros(shape)})
    assert str(caught.value) == (
        f"{name} has shape {shape}; expected ({VIEWS}, 6)"
    )
