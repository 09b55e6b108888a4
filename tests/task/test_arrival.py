"""The conditions for a target that counts as reached."""

import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.task.arrival import ArrivalConfig, has_arrived


def error(p_ET, angle_deg: float = 0.0) -> PoseError:
    p_ET = np.array(p_ET, float)
    return PoseError(p_ET, np.array([0, 0, np.radians(angle_deg)]), p_ET)


@pytest.mark.parametrize(
    ("p_ET", "angle_deg", "arrived"),
    [
        ((0, 0, 0), 0, True),
        ((0.019, 0, 0), 1.9, True),
        ((0.021, 0, 0), 0, False),
        ((0, 0, 0), 2.1, False),
        # 18 mm away, though the sum of the errors is 31 mm.
        ((0.0104, 0.0104, -0.0104), 0, True),
    ],
)
def test_the_papers_text_asks_for_distance_and_angle(p_ET, angle_deg, arrived):
    assert has_arrived(error(p_ET, angle_deg), ArrivalConfig()) == arrived


@pytest.mark.parametrize(
    ("p_ET", "angle_deg", "arrived"),
    [
        ((0.019, 0, 0), 170, True),
        ((0.0104, 0.0104, -0.0104), 0, False),
        ((0.006, -0.006, 0.006), 90, True),
    ],
)
def test_the_authors_code_asks_for_the_sum_of_the_translation(
    p_ET, angle_deg, arrived
):
    config = ArrivalConfig(rule="authors")
    assert has_arrived(error(p_ET, angle_deg), config) == arrived


def test_tolerances_are_parameters():
    loose = ArrivalConfig(position=0.1, angle=20)
    assert has_arrived(error((0.09, 0, 0), 19), loose)


@pytest.mark.parametrize(
    ("field", "value"), [("rule", "paper"), ("position", 0), ("angle", -1)]
)
def test_unusable_rules_are_named(field, value):
    with pytest.raises(FieldError, match=f"ArrivalConfig: {field}: "):
        ArrivalConfig(**{field: value})
