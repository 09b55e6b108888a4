"""All cases of the fault campaign, from the files of their themes."""

from remosplat_drake.acceptance.cases import (
    arm,
    controller,
    network,
    robot,
    target,
)

CASES = (
    *robot.CASES,
    *arm.CASES,
    *controller.CASES,
    *network.CASES,
    *target.CASES,
)
"""All cases of the campaign."""
