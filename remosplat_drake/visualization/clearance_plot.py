"""Makes the plot of the smallest clearance, for all pages."""

from remosplat_drake.visualization.svg_plot import Mark, SvgPlot

AMBER, RED = "#a86400", "#c8102e"
"""Colours of the stopping distance, and of the range below it."""

_NEAR = 0.2
"""Largest clearance that the plot shows [m]."""


def clearance_plot(stopping: float, influence: float, **looks) -> SvgPlot:
    """Makes a plot of the smallest clearance.

    Args:
        stopping: Clearance at which the controller stops approaching [m].
        influence: Influence distance: larger clearances are not measured [m].
        **looks: Further fields of `SvgPlot`, such as the time axis.
    """
    upper = min(influence, _NEAR)
    return SvgPlot(
        title="Smallest clearance",
        unit="m",
        lower=-0.2 * upper,
        upper=upper,
        marks=(
            Mark(stopping, f"stopping distance {stopping:g} m", AMBER),
            Mark(0.0, "contact", RED),
        ),
        **looks,
    )
