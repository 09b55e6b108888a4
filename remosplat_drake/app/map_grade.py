"""Grades a map by a single word."""

from remosplat_drake.app.map_knowledge import MapError
from remosplat_drake.controller.ingredients import CollisionDamperConfig
from remosplat_drake.reconstruction.report.quality_report import (
    MAP_ERROR_MARGIN,
)
from remosplat_drake.task.suggestion import NEAR

GOOD, FAIR, POOR, UNKNOWN = "good", "fair", "poor", "unknown"
"""Names of the grades; `grade_map` states their meanings."""

GRADE_STYLES = {
    GOOD: "bold green",
    FAIR: "bold yellow",
    POOR: "bold red",
    UNKNOWN: "bold yellow",
}
"""Styles of the grades in a terminal."""


def grade_map(error: MapError) -> str:
    """Grades a map by the smallest stopping distance that its error allows.

    Args:
        error: The map's error.

    Returns:
        `GOOD`: the usual stopping distance is safe. `FAIR`: only a larger
        stopping distance is safe, or the capture had problems. `POOR`: a safe
        stopping distance is too large for work near objects. `UNKNOWN`: the
        error has not been measured.
    """
    if error.largest is None:
        return UNKNOWN
    least = error.largest + MAP_ERROR_MARGIN
    if least >= NEAR:
        return POOR
    if error.warnings or least > CollisionDamperConfig().stopping:
        return FAIR
    return GOOD


def wrong_by(largest: float) -> str:
    """Formats the bound on a map's error, as "wrong by up to 9.0 mm".

    Args:
        largest: The bound [m].
    """
    return f"wrong by up to {1e3 * largest:.1f} mm"
