"""Faults: the network between robot and controller delays or loses messages."""

from remosplat_drake.acceptance.fault_case import (
    GOES_ON,
    FaultCase,
    Part,
)

CASES = (
    # No release is requested during the fault: the age of the delayed statuses
    # varies around its limit, so a release may or may not be refused.
    FaultCase(
        "network delay 50 ms, loss 20 %",
        Part.NETWORK,
        delay=0.05,
        loss=0.2,
        reason="PANDA_STATUS",
    ),
    FaultCase("network loss 20 %", Part.NETWORK, loss=0.2, outcome=GOES_ON),
)
