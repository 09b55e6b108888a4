"""Faults of the control process and of its map."""

from remosplat_drake.acceptance.fault_case import (
    DRIVER_STOPS,
    ENDS,
    GOES_ON,
    FaultCase,
    Part,
    controller_fault,
)
from remosplat_drake.safety.supervisor_system import STOP_BUTTON
from remosplat_drake.signals.tick_report import BRAKING, RELAXED

CASES = (
    FaultCase(
        "controller killed", Part.CONTROLLER_KILLED, outcome=DRIVER_STOPS
    ),
    controller_fault("controller hangs", "hang", "", outcome=DRIVER_STOPS),
    controller_fault("exception in a tick", "exception", "", outcome=ENDS),
    FaultCase("Ctrl-C", Part.INTERRUPT, outcome=ENDS),
    controller_fault("stop button", "stop-button", STOP_BUTTON),
    controller_fault(
        "stale map",
        "map-age",
        "the map is",
        refusal="the map is",
        text="{supervisor: {max_map_age: 0.5}}",
    ),
    controller_fault(
        "map unknown (NaN)",
        "map-nan",
        "clearance",
        refusal="clearance",
        tick_status=BRAKING,
    ),
    controller_fault(
        "QP infeasible for 1.2 s",
        "infeasible",
        "",
        outcome=GOES_ON,
        tick_status=RELAXED,
        watch=2.5,
    ),
)
