"""The report as one page of HTML: its tables, and plots of them."""

import html
from collections.abc import Sequence

from remosplat_drake.benchmark.plots import (
    box_plot,
    rate_plot,
    success_plot,
    timing_plot,
)
from remosplat_drake.benchmark.result import TrialResult
from remosplat_drake.benchmark.summary import Comparison, gather
from remosplat_drake.benchmark.tables import Table

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto;
       max-width: 90em; padding: 0 1em; color: #222; }
table { display: block; overflow-x: auto; border-collapse: collapse;
        font-variant-numeric: tabular-nums; }
td, th { padding: .25em .7em; text-align: right; white-space: nowrap; }
td:first-child, th:first-child { text-align: left; }
thead { border-bottom: 2px solid #888; }
tbody tr:nth-child(even) { background: #f4f4f4; }
figure { display: inline-block; margin: 1em; vertical-align: top; }
p { color: #555; max-width: 60em; }
"""


def to_html(
    results: Sequence[TrialResult], tables: Sequence[Table], heading: str
) -> str:
    """One self-contained page: plots of results, and the report's tables."""
    parts = [_figures(comparison) for comparison in gather(results)]
    parts += [table.to_html() for table in tables]
    title = html.escape(heading)
    body = "\n".join(parts)
    return (
        "<!doctype html>\n"
        f'<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f"<style>{STYLE}</style></head>\n"
        f"<body><h1>{title}</h1>\n{body}</body></html>\n"
    )


def _figures(comparison: Comparison) -> str:
    plots = {
        "Success by the paper's text": success_plot(comparison),
        "Smallest true clearance": box_plot(
            comparison, "minimum_distance", "clearance [m]"
        ),
        "End-effector acceleration": box_plot(
            comparison, "gracefulness", "mean |a| [m/s²]"
        ),
        "Time of a control tick": timing_plot(comparison),
        "Control rate and splats": rate_plot(comparison),
    }
    figures = "\n".join(
        f"<figure><figcaption>{html.escape(caption)}</figcaption>{svg}</figure>"
        for caption, svg in plots.items()
        if svg
    )
    return f"<h2>{html.escape(comparison.title)}</h2>\n{figures}\n"
