"""Faults of the robot and of its statuses."""

from remosplat_drake.acceptance.fault_case import (
    FaultCase,
    Part,
    robot_fault,
)

_SLOW = "{hardware: {arm_status_rate: 20}}"
"""Settings for statuses that are as rare as those of the slowest drivers."""

CASES = (
    robot_fault("status stops", "status-stops", "nothing came for"),
    robot_fault(
        "statuses of the arm 0.1 s late",
        "status-delay",
        "PANDA_STATUS",
        value=0.1,
    ),
    robot_fault(
        "status stops, of 20 a second",
        "status-stops",
        "nothing came for",
        text=_SLOW,
        robot=("--scenario-text", _SLOW),
    ),
    # The reason of the stop is not compared. If the robot moves, its frozen
    # statuses contradict the model of its actuators before they count as
    # frozen.
    robot_fault(
        "status freezes, stamps fresh",
        "status-freezes",
        "",
        refusal="frozen for",
    ),
    robot_fault("NaN in status", "status-nan", "is nan"),
    robot_fault("6 joints in status", "status-joints", "not 7", value=6.0),
    robot_fault(
        "clock jumps 1 s ahead", "clock-jump", "stamps jumped", value=1.0
    ),
    robot_fault(
        "clock jumps 1 s back", "clock-jump", "stamps jumped", value=-1.0
    ),
    robot_fault("reflex of the arm", "reflex", "reflex"),
    robot_fault(
        "reflex, then status stops",
        "reflex",
        "reflex",
        then="status-stops",
    ),
    robot_fault("user stop of the arm", "user-stop", "user_stopped"),
    robot_fault(
        "base status stops", "base-status-stops", "BASE_STATUS: nothing"
    ),
    robot_fault(
        "base protective stop, ends by itself",
        "base-protective-stop",
        "protective stop",
        watch=3.0,
    ),
    robot_fault(
        "emergency stop of the base", "base-emergency-stop", "emergency"
    ),
    robot_fault(
        "half of the arm's packets lost",
        "packet-loss",
        "commands reach the arm",
        value=0.5,
    ),
    FaultCase(
        "driver killed and restarted",
        Part.DRIVER_KILLED,
        reason="nothing came for",
        refusal="nothing came for",
        watch=2.0,
    ),
)
