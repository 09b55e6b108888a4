"""Draws the six depth views of a robot sphere as an unfolded cube."""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure

from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.oracle.depth_sensor import N_VIEWS
from remosplat_drake.oracle.view_images import SphereViews

VIEW_NAMES = ("+z", "−y", "+y", "+x", "−z", "−x")
"""Viewing directions of the six views, as axes of the sensor's frame."""

# Row and column of each view in the unfolded cube. Adjacent views share an edge
# of the cube.
_CELLS = ((1, 1), (0, 1), (2, 1), (1, 2), (1, 3), (1, 0))
_ROWS, _COLUMNS = 3, 4
_CELL = 3.0  # Side of a view on paper [in].
_GAP = 0.1
_MARGIN = 0.35
_HEADER = 0.95
_DPI = 120

_INK, _FAINT, _NOTHING = "#1d2430", "#7a8494", "#e9ecf1"
_NEAR, _NEAREST = "#ffffff", "#ff3b30"


def draw_depth_views(views: SphereViews, title: str, subtitle: str) -> Figure:
    """Draws the views of a sphere.

    The colour of a pixel is its range; grey pixels have no surface.

    Args:
        views: The six depth views of the sphere.
        title: Title of the picture, such as the name of the sphere.
        subtitle: Line below the title, such as the position of the sphere.
    """
    width = 2 * _MARGIN + _COLUMNS * _CELL + (_COLUMNS - 1) * _GAP
    height = 2 * _MARGIN + _HEADER + _ROWS * _CELL + (_ROWS - 1) * _GAP
    figure = Figure(figsize=(width, height), dpi=_DPI, facecolor="white")
    top = 1 - _MARGIN / height
    left = _MARGIN / width
    figure.text(left, top, title, va="top", size=21, weight="bold", color=_INK)
    figure.text(
        left, top - 0.45 / height, subtitle, va="top", size=13, color=_FAINT
    )
    cmap, norm = _colors(views.ranges)
    clearances = views.clearances
    nearest = int(clearances.argmin()) if _sees(views) else -1
    for view in range(N_VIEWS):
        axes = _add_cell(figure, *_CELLS[view])
        image = np.ma.masked_invalid(views.ranges[view])
        axes.imshow(image, cmap, norm, interpolation="nearest")
        axes.set(xticks=[], yticks=[])
        axes.spines[:].set_color(_FAINT)
        _name(axes, VIEW_NAMES[view])
        if np.isfinite(clearances[view]):
            _mark(axes, views, view, view == nearest)
    _add_table(figure, views, nearest)
    _add_color_bar(figure, ScalarMappable(norm, cmap))
    return figure


def save_picture(figure: Figure, path: Path) -> None:
    """Writes a figure as a PNG file, atomically.

    Raises:
        FileError: The file cannot be written.
    """
    with atomic_write(path, "wb") as file:
        figure.savefig(file, format="png")


def range_colors(ranges: np.ndarray) -> np.ndarray:
    """Returns the colours that ranges have in the picture.

    Args:
        ranges: Finite ranges, shape (n,) [m].

    Returns:
        Red, green and blue from 0 to 1, shape (n, 3).
    """
    cmap, norm = _colors(ranges)
    return cmap(norm(ranges))[:, :3]


def _colors(ranges: np.ndarray) -> tuple[Colormap, Normalize]:
    seen = ranges[np.isfinite(ranges)]
    low, high = (seen.min(), seen.max()) if seen.size else (0.0, 1.0)
    cmap = matplotlib.colormaps["viridis_r"].with_extremes(bad=_NOTHING)
    return cmap, Normalize(low, max(high, low + 1e-3))


def _sees(views: SphereViews) -> bool:
    return bool(np.isfinite(views.clearances).any())


def _add_cell(figure: Figure, row: float, column: float, columns=1) -> Axes:
    """Adds the axes of a cell of the unfolded cube, placed in inches."""
    width, height = figure.get_size_inches()
    step = _CELL + _GAP
    x = _MARGIN + column * step
    y = height - _MARGIN - _HEADER - row * step - _CELL
    w = columns * _CELL + (columns - 1) * _GAP
    return figure.add_axes((x / width, y / height, w / width, _CELL / height))


def _name(axes: Axes, text: str):
    axes.text(
        0.03,
        0.97,
        text,
        transform=axes.transAxes,
        va="top",
        size=11,
        weight="bold",
        color=_INK,
        bbox={"facecolor": "white", "alpha": 0.8, "lw": 0, "pad": 3},
    )


def _mark(axes: Axes, views: SphereViews, view: int, is_nearest: bool):
    """Draws a ring around a view's nearest pixel, with its clearance."""
    row, column = views.nearest[view].tolist()
    size = views.ranges.shape[1]
    color = _NEAREST if is_nearest else _NEAR
    # Rings and labels may extend into the neighbouring view.
    axes.set_zorder(2 if is_nearest else 1)
    for edge, line in ((_INK, 4.5), (color, 2.5)):
        axes.plot(
            *(column, row),
            "o",
            ms=13,
            mfc="none",
            mec=edge,
            mew=line,
            clip_on=False,
        )
    right, low = column > size / 2, row < size / 2
    axes.annotate(
        format_length(views.clearances[view]),
        (column, row),
        (-13 if right else 13, -13 if low else 13),
        textcoords="offset points",
        ha="right" if right else "left",
        va="top" if low else "bottom",
        size=12,
        weight="bold",
        color="white" if is_nearest else _INK,
        bbox={"facecolor": color, "lw": 0, "boxstyle": "round,pad=0.3"},
    )


def _add_table(figure: Figure, views: SphereViews, nearest: int):
    axes = _add_cell(figure, 0, 2, columns=2)
    axes.set_axis_off()
    columns = (0.02, 0.36, 0.62, 1.0)
    rows = [["view", "clearance", "range", "closest point in W [m]"]]
    for view in range(N_VIEWS):
        row = [VIEW_NAMES[view], "nothing seen", "", ""]
        if np.isfinite(views.clearances[view]):
            clearance = views.clearances[view]
            row[1:3] = map(format_length, (clearance, clearance + views.radius))
            row[3] = "  ".join(
                f"{x:.3f}".replace("-", "−") for x in views.nearest_points[view]
            )
        rows.append(row)
    for i, row in enumerate(rows):
        for j, (x, text) in enumerate(zip(columns, row, strict=True)):
            axes.text(
                x,
                0.95 - 0.135 * i,
                text,
                ha="left" if j == 0 else "right",
                va="top",
                size=12,
                weight="bold" if i == nearest + 1 and i else "normal",
                color=(
                    _FAINT if i == 0 else _NEAREST if i == nearest + 1 else _INK
                ),
            )
    axes.plot([0.02, 1], [0.86, 0.86], color=_FAINT, lw=0.8)
    axes.set(xlim=(0, 1), ylim=(0, 1))


def _add_color_bar(figure: Figure, colors: ScalarMappable):
    axes = _add_cell(figure, 2, 2, columns=2)
    axes.set_axis_off()
    bar = axes.inset_axes((0.02, 0.5, 0.98, 0.1))
    color_bar = figure.colorbar(colors, cax=bar, orientation="horizontal")
    color_bar.set_label(
        "range from the sphere's centre [m]", size=12, color=_INK
    )
    color_bar.outline.set_edgecolor(_FAINT)  # pyright: ignore
    bar.tick_params(labelsize=11, colors=_INK)
    axes.text(
        0.02,
        0.08,
        "grey: no surface in front of the far plane\nring: closest pixel of a "
        "view, with its clearance; red ring: closest of all views",
        size=11,
        linespacing=1.5,
        color=_FAINT,
        transform=axes.transAxes,
    )


def format_length(length: float) -> str:
    """Formats a length [m] in whole millimetres."""
    return f"{1e3 * length:.0f} mm".replace("-", "−")
