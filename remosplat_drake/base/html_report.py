"""Parts of self-contained HTML reports: style, cards and plots."""

import html
import io
from collections.abc import Mapping
from typing import Any

STYLE = """
:root { --ink: #1f2933; --soft: #616e7c; --line: #d9e2ec; --wash: #f5f7fa; }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink);
       margin: 2.5em auto; max-width: 74em; padding: 0 1.5em; }
h1 { font-size: 1.7em; margin: 0; }
h2 { font-size: 1.2em; margin: 2.4em 0 .6em; padding-bottom: .25em;
     border-bottom: 1px solid var(--line); }
h3 { font-size: 1em; margin: 2em 0 .5em; }
p { color: var(--soft); max-width: 62em; }
.method { color: var(--soft); margin: .2em 0 1.4em; }
.trust { background: var(--wash); border-left: .3em solid #2f6fae;
         color: var(--ink); font-size: 1.08em; padding: .9em 1.2em; }
.warnings { border-left: .3em solid #b54708; background: #fff6ed;
            padding: .7em 1.2em .7em 2.4em; }
.cards { display: grid; gap: .8em; margin: 1.4em 0;
         grid-template-columns: repeat(auto-fit, minmax(10em, 1fr)); }
.card { border: 1px solid var(--line); border-radius: .5em;
        padding: .7em 1em; }
.card b { display: block; font-size: 1.45em; font-weight: 600;
          font-variant-numeric: tabular-nums; }
.card span { color: var(--soft); font-size: .88em; }
.table { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .35em .9em; text-align: right; }
td { white-space: nowrap; }
th { color: var(--soft); font-weight: 600; vertical-align: bottom; }
th.text, td.text { text-align: left; }
thead { border-bottom: 2px solid var(--line); }
tbody tr + tr { border-top: 1px solid var(--line); }
tr.quoted { color: var(--soft); font-style: italic; }
.plots { display: grid; gap: 1.2em; margin: 1.4em 0;
         grid-template-columns: repeat(auto-fit, minmax(26em, 1fr)); }
figure { margin: 0; }
figcaption { color: var(--soft); font-size: .88em; font-weight: 600; }
svg { max-width: 100%; height: auto; }
"""
"""Style sheet (CSS) of a report."""

OURS, OTHERS = "#2f6fae", "#b54708"
"""Colours of two curves in plots: the subject of the report, and the reference
with which the subject is compared."""


def make_page(title: str, body: str, style: str = "") -> str:
    """Returns a self-contained HTML page, which loads no other files.

    Args:
        title: The page's title and heading, as text.
        body: The part after the heading, as HTML.
        style: CSS rules for the page in addition to `STYLE`.
    """
    name = html.escape(title)
    return (
        "<!doctype html>\n"
        f'<html lang="en"><head><meta charset="utf-8"><title>{name}</title>'
        '<meta name="viewport" content="width=device-width">'
        f"<style>{STYLE}{style}</style></head>\n"
        f"<body>\n<h1>{name}</h1>\n{body}\n</body></html>\n"
    )


def cards(values: Mapping[str, str]) -> str:
    """Returns HTML that highlights some numbers, each in a card with a label.

    Args:
        values: The numbers as formatted text, keyed by label.
    """
    inner = "".join(
        f'<div class="card"><b>{html.escape(value)}</b>'
        f"<span>{html.escape(label)}</span></div>"
        for label, value in values.items()
    )
    return f'<div class="cards">{inner}</div>'


def new_plot(width: float, height: float) -> tuple[Any, Any]:
    """Makes a matplotlib figure with one plot.

    Args:
        width: Width of the figure [inches].
        height: Height of the figure [inches].

    Returns:
        The axes of the plot, and the figure.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots()
    axes.spines[["top", "right"]].set_visible(False)
    return axes, figure


def to_svg(figure: Any) -> str:
    """Returns a matplotlib figure as SVG text, which a page can contain."""
    from matplotlib import rc_context

    text = io.StringIO()
    # Element names are hashes, so that equal figures give equal text.
    with rc_context({"svg.hashsalt": "remosplat"}):
        figure.savefig(text, format="svg", metadata={"Date": None})
    # The XML header is removed, since it is not valid inside a page.
    return text.getvalue()[text.getvalue().index("<svg") :]
