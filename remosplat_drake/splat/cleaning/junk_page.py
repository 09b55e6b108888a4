"""Makes an HTML page that shows the removed splats in two views."""

import html
from pathlib import Path

import numpy as np

from remosplat_drake.base.html_report import make_page
from remosplat_drake.base.table import Table
from remosplat_drake.splat.cleaning.junk import (
    FAINT,
    FLOATER,
    GIANT,
    KEPT,
    NEEDLE,
    REASONS,
    SKY,
    UNSEEN,
    Junk,
)

UNBOUNDED = (
    "The error of the remaining splat has no bound: surfaces that training "
    "missed are still missing, and only a capture of the place can measure "
    "errors of distances."
)
"""Sentence on the page about the limits of cleaning."""

_COLORS = {
    KEPT: "#9aa5b1",
    FAINT: "#7c4dbc",
    GIANT: "#d64545",
    NEEDLE: "#c99a06",
    SKY: "#2f6fae",
    FLOATER: "#e8590c",
    UNSEEN: "#2b8a3e",
}
_OTHER = "#c2255c"

_MOST = 20_000
"""A view shows at most this many points of one colour, so that browsers draw it
fast."""

_SIDE = 620
"""Length of a view's side [px]."""

_RADII = 2.5
"""Half the side of a view, as a multiple of the radius of the kept splats.
Splats farther away are drawn at the border."""

_STYLE = """
.dot { display: inline-block; width: .8em; height: .8em; border-radius: 50%;
       margin: 0 .35em 0 1em; }
.views { display: flex; flex-wrap: wrap; gap: 1.2em; }
.views svg { border: 1px solid var(--line); }
"""


def page_path(splat: Path) -> Path:
    """Returns the path of the page about a splat file that was cleaned."""
    return splat.with_suffix(".clean.html")


def junk_table(junk: Junk) -> Table:
    """Makes a table with the number of removed splats for each reason.

    Args:
        junk: The removed splats.
    """
    n = len(junk.reason)
    removed = n - int(np.count_nonzero(junk.is_kept))
    rows = tuple(
        (name, because, f"{count:,}", f"{100 * count / n:.2f} %")
        for name, because, count in (
            *((k, REASONS[k], count) for k, count in junk.counts().items()),
            ("in all", "", removed),
        )
    )
    header = ("removed", "because it is", "splats", "share")
    return Table("", header, rows, texts=2)


def junk_page(junk: Junk, p_FK: np.ndarray, title: str, upright: bool) -> str:
    """Returns an HTML page with views from above and from the side.

    Args:
        junk: The removed splats.
        p_FK: Centres of all splats in the frame F of the pictures, shape
            (N, 3).
        title: Heading, such as the splat's name.
        upright: Whether F's z axis is known to be up.
    """
    kept = p_FK[junk.is_kept] if junk.is_kept.any() else p_FK
    middle = np.median(kept, axis=0)
    distance = np.linalg.norm(kept - middle, axis=1)
    half = _RADII * max(float(np.quantile(distance, 0.99)), 1e-9)
    p_M = np.clip((p_FK - middle) / half, -1, 1)
    views = {"from above": (0, 1), "from the side": (0, 2)}
    if not upright:
        views = {"along A's z axis": (0, 1), "along A's y axis": (0, 2)}
    drawn = "".join(
        f"<figure>{_view(p_M[:, list(axes)], junk)}"
        f"<figcaption>{name}, {2 * half:.3g} wide</figcaption></figure>"
        for name, axes in views.items()
    )
    legend = "".join(
        f'<span class="dot" style="background:{_color(name)}"></span>{name}'
        for name in (KEPT, *(k for k, n in junk.counts().items() if n))
    )
    body = (
        f'<p class="trust">{html.escape(UNBOUNDED)}</p>\n'
        f"{junk_table(junk).to_html()}\n<p>{legend}</p>\n"
        f'<div class="views">{drawn}</div>\n'
        "<p>Splats outside the pictures are drawn at their border; at most "
        f"{_MOST:,} splats of each colour are drawn.</p>"
    )
    return make_page(f"Cleaned: {title}", body, _STYLE)


def _view(p_M: np.ndarray, junk: Junk) -> str:
    """Draws points in [-1, 1] as SVG, with one path of dots for each colour."""
    x = np.rint(0.5 * _SIDE * (1 + p_M[:, 0])).astype(int)
    y = np.rint(0.5 * _SIDE * (1 - p_M[:, 1])).astype(int)
    paths = []
    for number, name in enumerate(junk.names):
        chosen = np.flatnonzero(junk.reason == number)
        chosen = chosen[:: len(chosen) // _MOST + 1]
        if not len(chosen):
            continue
        places = np.unique(np.stack([x[chosen], y[chosen]], axis=1), axis=0)
        dots = "".join(f"M{u} {v}h0" for u, v in places.tolist())
        width = 1 if name == KEPT else 3
        paths.append(
            f'<path d="{dots}" stroke="{_color(name)}" stroke-width="{width}"'
            ' stroke-linecap="round"/>'
        )
    return (
        f'<svg width="{_SIDE}" height="{_SIDE}" viewBox="0 0 {_SIDE} {_SIDE}">'
        f"{''.join(paths)}</svg>"
    )


def _color(name: str) -> str:
    return _COLORS.get(name, _OTHER)
