"""All cases of the fault campaign, from the files of their themes."""

from remosplat_drake.acceptance.cases import (
    arm,
    base,
    controller,
    master,
    motion,
    network,
    robot,
    target,
)

CASES = (
    *robot.CASES,
    *arm.CASES,
    *base.CASES,
    *controller.CASES,
    *master.CASES,
    *motion.CASES,
    *network.CASES,
    *target.CASES,
)
"""All cases of the campaign."""
