"""The plot of the smallest clearance, the same on every page."""

from remosplat_drake.visualization.svg_plot import Mark, SvgPlot

AMBER, RED = "#a86400", "#c8102e"
"""Colours of the distance to keep, and of the forbidden range."""

_NEAR = 0.2
"""Clearance up to which it is shown, since only small ones matter [m]."""


def clearance_plot(stopping: float, influence: float, **looks) -> SvgPlot:
    """Makes a plot of the smallest clearance.

    Args:
        stopping: Clearance at which the controller stops approaching [m].
        influence: Clearance beyond which the oracle reports none [m].
        **looks: Further fields of `SvgPlot`, such as its time axis.
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
