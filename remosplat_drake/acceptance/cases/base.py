"""Faults of the base: unreported stops, wrong poses, wrong clocks."""

from remosplat_drake.acceptance.fault_case import (
    MISMATCH,
    FaultCase,
    robot_fault,
)

_SPEEDS = (0.05, 0.2, 0.5)
"""Speeds of the base at the time of the unreported stop [m/s]."""

_LOCALIZED = {
    "robot": ("--localization",),
    "text": "{hardware: {localization: {}}}",
}


def _unnoticed(what: str, fault: str, speed: float) -> FaultCase:
    """Makes a case in which the base stops without a report, as on ROS."""
    return robot_fault(
        f"{what} through ROS at {speed:g} m/s",
        "base-mute",
        "does not move as it should",
        then=fault,
        # No refusal of a release is expected, since a base that is at rest,
        # with zero commands, shows no fault.
        refusal=None,
        watch=3.0,
        text=f"{{time_limit: 60, controller: {{velocity_limits:"
        f" {{max_forward: {speed}}}}}}}",
    )


CASES = (
    *(_unnoticed("emergency stop", "base-emergency-stop", v) for v in _SPEEDS),
    *(
        _unnoticed("protective stop", "base-protective-stop", v)
        for v in _SPEEDS
    ),
    robot_fault("odometry jumps 5 cm", "base-jump", "jumped by", value=0.05),
    robot_fault("odometry jumps 30 cm", "base-jump", "jumped by", value=0.3),
    robot_fault(
        "odometry drifts 2 cm/s",
        "base-drift",
        MISMATCH,
        value=0.02,
        refusal=None,
        watch=3.0,
    ),
    robot_fault(
        "clock of the base 0.2 s behind",
        "base-clock",
        "set the clocks",
        value=-0.2,
    ),
    robot_fault(
        "clock of the base 0.2 s ahead",
        "base-clock",
        "set the clocks",
        value=0.2,
    ),
    robot_fault(
        "localisation jumps 5 cm",
        "localization-jump",
        "jumped by",
        value=0.05,
        **_LOCALIZED,
    ),
    robot_fault(
        "localisation jumps 30 cm",
        "localization-jump",
        "jumped by",
        value=0.3,
        **_LOCALIZED,
    ),
    robot_fault(
        "localisation drifts 2 cm/s",
        "localization-drift",
        # The reason of the stop varies: the controller may detect a motion that
        # the commands do not explain, or a jump of the pose.
        "",
        value=0.02,
        # At the end of the fault, the drift stops, but its error remains. This
        # error is about the largest permitted error of a localisation.
        resumes=None,
        **_LOCALIZED,
    ),
    robot_fault(
        "localisation in a wrong frame",
        "localization-frame",
        "frame_id is 'odom'",
        **_LOCALIZED,
    ),
    robot_fault(
        "localisation falls silent",
        "localization-stops",
        "nothing new came for",
        **_LOCALIZED,
    ),
)
