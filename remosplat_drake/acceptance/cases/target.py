"""Fault: the target jumps to a place that the robot cannot reach."""

from remosplat_drake.acceptance.fault_case import (
    GOES_ON,
    MOVES,
    FaultCase,
    Part,
)

THROUGH_THE_TABLE = """
arrival: {position: 0.35, angle: 180}
targets:
- {translation: [1.15, 0.0, 0.66], rpy_deg: [180, 0, 0]}
- {translation: [1.3, 0.0, 0.2], rpy_deg: [180, 0, 0]}
"""
"""Two targets. The first counts as reached while the arm is still on its way.
The target then jumps to the second one, which is below the table top.
"""

CASES = (
    FaultCase(
        "target jumps through the table",
        Part.TARGET,
        outcome=GOES_ON,
        watch=4.0,
        text=THROUGH_THE_TABLE,
    ),
    FaultCase(
        "target through the table, jumps up to 0.2 m",
        Part.TARGET,
        reason="the target jumped",
        resumes=MOVES,
        text=THROUGH_THE_TABLE + "supervisor: {max_target_jump: 0.2}\n",
    ),
)
