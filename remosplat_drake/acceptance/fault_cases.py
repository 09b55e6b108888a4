"""Collects all cases of the fault campaign."""

from remosplat_drake.acceptance.cases import (
    arm,
    base,
    controller,
    late,
    master,
    network,
    robot,
    ros2,
    target,
)

CASES = (
    *robot.CASES,
    *arm.CASES,
    *base.CASES,
    *controller.CASES,
    *late.CASES,
    *master.CASES,
    *network.CASES,
    *target.CASES,
    *ros2.CASES,
)
"""All cases of the campaign."""
