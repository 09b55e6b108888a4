"""Requests that open and close a hand."""

import pytest

from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.teleop.hand_motion import HandLaw, advance_hand

BEFORE = OperatorCommand(opens=2, closes=3)


@pytest.mark.parametrize("is_open", [True, False])
@pytest.mark.parametrize(
    ("opens", "closes", "expected"),
    [(2, 3, None), (3, 3, True), (2, 4, False), (3, 4, False)],
)
def test_the_newest_request_counts(is_open, opens, closes, expected):
    """Without one the hand stays; of two it closes, and drops nothing."""
    now = OperatorCommand(opens=opens, closes=closes)
    expected = is_open if expected is None else expected
    assert advance_hand(BEFORE, now, is_open=is_open) is expected


def test_an_open_hand_is_as_wide_as_its_collision_geometry():
    law = HandLaw(width=0.08, force=20.0)
    assert law.command(is_open=True) == (0.08, 20.0)
    assert law.command(is_open=False) == (0.0, 20.0)
