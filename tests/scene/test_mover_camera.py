"""Images of a camera that watches for movers."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import FieldError
from remosplat_drake.scene.mover_camera import MoverCamera


def make(**fields) -> MoverCamera:
    """It looks along x of W from a metre above its origin."""
    given = {
        "name": "room",
        "X_WC": RigidTransform(
            RollPitchYaw(-np.pi / 2, 0, -np.pi / 2), [0, 0, 1]
        ),
        "least_tangent": [-0.5, -0.25],
        "greatest_tangent": [0.5, 0.25],
        "near": 0.3,
        "far": 4.0,
        "seen": 1.0,
    }
    return MoverCamera(**{**given, **fields})


@pytest.mark.parametrize(
    ("p_W", "framed"),
    [
        ([2.0, 0.0, 1.0], True),
        ([2.0, 0.99, 1.0], True),
        ([2.0, 1.01, 1.0], False),
        ([2.0, 0.0, 1.49], True),
        ([2.0, 0.0, 1.51], False),
        ([0.29, 0.0, 1.0], False),
        ([4.01, 0.0, 1.0], False),
        ([-2.0, 0.0, 1.0], False),
    ],
)
def test_what_is_in_its_picture(p_W, framed):
    assert make().frames(np.array([p_W])).tolist() == [framed]


@pytest.mark.parametrize(
    "fields",
    [
        {"least_tangent": [0.5, 0.0]},
        {"least_tangent": [np.nan, 0.0]},
        {"near": 5.0},
        {"near": np.nan},
        {"far": np.inf},
        {"seen": np.inf},
    ],
)
def test_what_watches_no_space_is_refused(fields):
    with pytest.raises(
        FieldError, match=f"camera 'room'.*{next(iter(fields))}"
    ):
        make(**fields)
