"""Narrower ranges of a scenario's fields for runs on a real robot."""

from functools import reduce

from annotated_types import Interval

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.ranges import range_problem

REQUIRED = (
    "supervisor.enabled",
    "controller.verify",
    "controller.self_collision.enabled",
)
"""Fields of a scenario whose value must be `true` for a real robot."""

NARROWER = {
    # Commands expire after a tenth of a second.
    "control_period": Interval(ge=0.002, le=0.05),
    "supervisor.max_status_age": Interval(gt=0, le=0.5),
    "supervisor.max_tick_age": Interval(gt=0, le=0.5),
    "supervisor.max_overrun": Interval(ge=0, le=0.5),
    "supervisor.min_success_rate": Interval(ge=0.5, le=1),
    "supervisor.success_rate_dwell": Interval(ge=0, le=1),
    "supervisor.clearance_margin": Interval(ge=0, le=0.02),
    "supervisor.clearance_dwell": Interval(ge=0, le=0.5),
    "supervisor.max_braking_time": Interval(ge=0, le=5),
    "supervisor.max_follow_error": Interval(gt=0, le=0.5),
    "supervisor.max_tracking_error": Interval(gt=0, le=10),
    "supervisor.follow_dwell": Interval(ge=0, le=2),
    "supervisor.max_movers_age": Interval(gt=0, le=0.5),
    "hardware.arm_status_expiry": Interval(gt=0, le=0.5),
    "hardware.base_status_expiry": Interval(gt=0, le=0.5),
    "hardware.hand_status_expiry": Interval(gt=0, le=1),
    "hardware.base_delay": Interval(ge=0, le=0.5),
    "hardware.localization.expiry": Interval(gt=0, le=3),
    "hardware.localization.sigmas": Interval(ge=2, le=6),
    "hardware.localization.max_shift": Interval(gt=0, le=0.3),
    "hardware.localization.max_turn": Interval(gt=0, le=0.3),
    # Other values scale splats down or ignore some of them, so the oracle would
    # miss obstacles.
    "oracle.n_sigma": Interval(ge=0.5, le=10),
    "oracle.min_opacity": Interval(ge=0, le=0.5),
    # Depth views do not show obstacles whose opacity is below this bound, or
    # whose distance is outside of these bounds.
    "oracle.alpha_cutoff": Interval(gt=0, le=0.9),
    "oracle.near": Interval(gt=0, le=0.05),
    "oracle.far": Interval(ge=0.5, le=100),
    "oracle.resolution": Interval(ge=20, le=2048),
}
"""Permitted ranges on a real robot, keyed by field of the scenario. A field
that the scenario's oracle does not have is not checked."""

HARDWARE_SPEED = 0.35
"""Default bound on the speed of a real robot's hands and, on a planned path, of
all of its parts [m/s]. A scenario may set a higher bound."""

COMMANDED_MODES = {"idle", "move"}
"""Modes of a real arm's driver in which the arm follows velocity commands."""


def check_for_hardware(scenario: Scenario) -> None:
    """Rejects a scenario that is not permitted on a real robot.

    Args:
        scenario: A scenario whose fields are valid for simulation.

    Raises:
        FieldError: A value, named in the text, disables a safety check: a
            switch is off, a number is outside of the ranges of `NARROWER`, or
            the chosen mode of the arm does not follow commands.
    """
    for field in REQUIRED:
        if not _value(scenario, field):
            problem = "must be true on a real robot"
            if scenario.controller.gains == "paper":
                problem += " (`gains: paper` disables it)"
            raise FieldError(scenario.source, field, problem)
    for field, bounds in NARROWER.items():
        value = _value(scenario, field)
        problem = "" if value is None else range_problem(value, [bounds])
        if problem:
            raise FieldError(
                scenario.source, field, f"on a real robot, it {problem}"
            )
    modes = set(scenario.supervisor.robot_modes) - COMMANDED_MODES
    if modes:
        raise FieldError(
            scenario.source,
            "supervisor.robot_modes",
            "a real arm does not follow commands in "
            f"{', '.join(sorted(modes))}; valid: "
            f"{', '.join(sorted(COMMANDED_MODES))}",
        )


def _value(scenario: Scenario, field: str) -> object:
    return reduce(
        lambda config, name: getattr(config, name, None),
        field.split("."),
        scenario,
    )
