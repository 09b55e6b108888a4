"""Faults of the arm's own driver, `remosplat panda-driver`."""

from remosplat_drake.acceptance.fault_case import FaultCase, Part

_DRIVEN = {
    "arm_driver": True,
    "watch": 2.0,
    # With these settings, the controller needs little time, since robot,
    # driver, callback and controller must not be late, even on few cores.
    "text": "{control_period: 0.02, controller: {guidance: {enabled: false}}}",
}

CASES = (
    FaultCase(
        "arm driver stalled",
        Part.ARM_DRIVER_STALLED,
        reason="nothing came for",
        refusal="nothing came for",
        **_DRIVEN,
    ),
    FaultCase(
        "arm driver's callback stalled",
        Part.ARM_CALLBACK_STALLED,
        reason="nothing came for",
        refusal="nothing came for",
        **_DRIVEN,
    ),
    # No refusal of a release is expected, since the driver reports the stop and
    # ends.
    FaultCase(
        "user stop, reported by the arm driver",
        Part.ROBOT,
        "user-stop",
        reason="user_stopped",
        **_DRIVEN,
    ),
)
"""Cases of the arm's driver, which connects the simulated arm to the
network."""
