"""When a target counts as reached."""

import dataclasses as dc
import math

from remosplat_drake.controller.servo import PoseError
from remosplat_drake.errors import FieldError, unknown_name


@dc.dataclass
class ArrivalConfig:
    """The success rule (paper section V, "Success Rate")."""

    # `text`: distance and angle, as the paper says. `authors`: the L1 norm
    # of the translation alone, as their code does.
    rule: str = "text"
    # Tolerance on the position [m].
    position: float = 0.02
    # Tolerance on the rotation [deg].
    angle: float = 2.0


RULES = ("text", "authors")


def has_arrived(error: PoseError, config: ArrivalConfig) -> bool:
    """Whether a pose error counts as arrival."""
    if config.rule == "authors":
        return error.distance_l1 < config.position
    return error.distance < config.position and error.angle < math.radians(
        config.angle
    )


def check_arrival(config: ArrivalConfig, where: str) -> None:
    """Checks the rule's name and its tolerances.

    Raises:
        FieldError: One of them is unusable.
    """
    if config.rule not in RULES:
        raise FieldError(
            where, "arrival.rule", unknown_name("rule", config.rule, RULES)
        )
    for field in ("position", "angle"):
        value = getattr(config, field)
        if value <= 0:
            raise FieldError(
                where, f"arrival.{field}", f"must be positive, got {value}"
            )
