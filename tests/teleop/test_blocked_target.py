"""An operator who means ill: the target goes where the robot must not."""

from operated import Operated

from remosplat_drake.signals.target_state import FOLLOW
from remosplat_drake.teleop.teleop_config import SavedPose, TeleopConfig


def test_a_target_pushed_through_the_table_does_not_take_the_robot_along():
    operated = Operated("TableReach", TeleopConfig())
    operated.wait(0.02)
    inside = SavedPose([1.3, -0.1, 0.3]).matrix()
    operated.say(source="test", X_WT=inside, moves=1)
    clearances = []
    for _ in range(40):
        operated.wait(0.2)
        clearances.append(operated.clearance)
    assert operated.state.mode == FOLLOW
    assert operated.target.error(operated.context).distance > 0.2
    assert min(clearances) > 0.0
    assert min(clearances) < 0.05  # It did come near.
    # Hold: the robot stays, the target is where it is.
    operated.say(holds=1)
    operated.wait(1.0)
    assert operated.target.error(operated.context).distance < 0.01
    assert operated.clearance > 0.0
