"""The robot obeys later and more slowly than its controller was told."""

from remosplat_drake.acceptance.fault_case import FaultCase, robot_fault

_REASON = "actuators' model"


def _late(name: str, fault: str, **more) -> FaultCase:
    """A robot that leaves the tube of its model; at rest nothing shows it."""
    return robot_fault(name, fault, _REASON, refusal=None, watch=2.0, **more)


CASES = (
    _late(
        "base 150 ms late, statuses 50 ms",
        "base-command-delay",
        value=0.15,
        then="base-status-delay",
    ),
    _late(
        "base 250 ms late, statuses 50 ms",
        "base-command-delay",
        value=0.25,
        then="base-status-delay",
    ),
    _late("arm under panda-py's law", "panda-py"),
)
