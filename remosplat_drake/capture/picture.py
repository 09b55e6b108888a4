"""Draws an overview of a capture: its frames, and a map with its cameras."""

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from remosplat_drake.capture.capture import Capture

_COLUMNS, _MOST = 6, 12
"""Number of frames in a row of the picture, and in the whole picture."""

_CELL, _MAP = 2.4, 9.0
"""Width of a frame, and height of the map, in the picture [in]."""

_POINTS = 60_000
"""Number of points in the map."""

_ABOVE = 0.5
"""Points that are farther than this above the highest camera, such as those of
a ceiling, are not drawn [m].
"""

_LOOK = 0.15
"""Length of the lines that show the cameras' viewing directions [m]."""

_INK, _FAINT, _UNKNOWN, _WRONG = "#1d2430", "#7a8494", "#e9ecf1", "#ff3b30"
_CAMERA = "#0a7cff"


def draw_capture(
    capture: Capture, title: str, wrong_frames: np.ndarray
) -> Figure:
    """Draws frames, each as colour above depth, and a map with the cameras.

    Args:
        capture: A capture of at least one frame.
        title: Title of the picture, such as the capture's name.
        wrong_frames: Indices of frames to draw in red.
    """
    shown = np.unique(np.linspace(0, len(capture) - 1, _MOST).round()).astype(
        int
    )
    rows = -(-len(shown) // _COLUMNS)
    height, width = capture.size
    sheet_rows = 2 * rows
    row_height = _CELL * height / width
    figure = Figure(
        figsize=(_COLUMNS * _CELL, sheet_rows * row_height + _MAP),
        dpi=100,
        facecolor="white",
        layout="tight",
    )
    figure.suptitle(title, size=18, weight="bold", color=_INK)
    grid = figure.add_gridspec(
        sheet_rows + 1,
        _COLUMNS,
        height_ratios=[row_height] * sheet_rows + [_MAP],
    )
    cmap, norm = _depth_colors(capture)
    wrong = set(wrong_frames.tolist())
    for place, view in enumerate(shown.tolist()):
        row, column = divmod(place, _COLUMNS)
        color = figure.add_subplot(grid[2 * row, column])
        color.imshow(capture.rgb[view])
        color.set_title(
            f"{view}", size=10, color=_WRONG if view in wrong else _INK
        )
        depth = figure.add_subplot(grid[2 * row + 1, column])
        image = capture.depth[view]
        depth.imshow(np.ma.masked_equal(image, 0), cmap, norm)
        for axes in (color, depth):
            axes.set(xticks=[], yticks=[])
            axes.spines[:].set_color(_WRONG if view in wrong else _FAINT)
    map_axes = figure.add_subplot(grid[sheet_rows, :])
    _draw_map(map_axes, capture, wrong_frames)
    bar = figure.colorbar(
        ScalarMappable(norm, cmap), ax=map_axes, fraction=0.03, pad=0.02
    )
    bar.set_label("depth of the images [m]; grey: unknown", color=_INK)
    return figure


def up_axis(capture: Capture) -> tuple[int, float]:
    """Finds the world axis that is closest to the cameras' upward direction.

    Files differ in which axis points up, but most cameras are held upright.

    Returns:
        Index of the axis, and its sign: 1.0 if it points up, else -1.0.
    """
    up_W = -capture.X_WC[:, :3, 1].mean(axis=0)
    axis = int(np.abs(up_W).argmax())
    return axis, float(np.sign(up_W[axis]) or 1.0)


def _depth_colors(capture: Capture):
    known = capture.depth[capture.depth > 0]
    low, high = np.percentile(known, (1, 99)) if known.size else (0.0, 1.0)
    cmap = colormaps["viridis_r"].with_extremes(bad=_UNKNOWN)
    return cmap, Normalize(low, max(high, low + 1e-3))


def _draw_map(axes: Axes, capture: Capture, wrong_frames: np.ndarray):
    """Draws points and cameras, seen from above."""
    up, sign = up_axis(capture)
    right, forward = (up + 1) % 3, (up + 2) % 3
    if sign < 0:
        right, forward = forward, right
    points, colors = _points(capture)
    p_WC = capture.X_WC[:, :3, 3]
    height = sign * points[:, up]
    low = height < (sign * p_WC[:, up]).max() + _ABOVE
    order = np.flatnonzero(low)[np.argsort(height[low])]
    axes.scatter(
        points[order, right],
        points[order, forward],
        c=colors[order] / 255,
        s=2,
        lw=0,
        rasterized=True,
    )
    axes.plot(p_WC[:, right], p_WC[:, forward], "-", color=_CAMERA, lw=0.8)
    strokes = p_WC + _LOOK * capture.X_WC[:, :3, 2]
    wrong = np.isin(np.arange(len(capture)), wrong_frames)
    for which, color in ((~wrong, _CAMERA), (wrong, _WRONG)):
        ends = np.stack([p_WC[which], strokes[which]])
        axes.plot(ends[..., right], ends[..., forward], color=color, lw=1.2)
        axes.plot(p_WC[which, right], p_WC[which, forward], "o", ms=4, c=color)
    names = "xyz"
    axes.set_title(
        f"from above ({'-' if sign < 0 else ''}{names[up]} is up):"
        " cameras, their viewing directions, and measured points",
        size=12,
        color=_INK,
    )
    axes.set(
        xlabel=f"{names[right]} [m]",
        ylabel=f"{names[forward]} [m]",
        aspect="equal",
    )
    axes.grid(alpha=0.3)


def _points(capture: Capture) -> tuple[np.ndarray, np.ndarray]:
    """Random measured points in W, (m, 3) [m], and their colours."""
    rng = np.random.default_rng(0)
    points, colors = [np.zeros((0, 3))], [np.zeros((0, 3))]
    for view in range(len(capture)):
        known = np.flatnonzero(capture.depth[view])
        count = min(len(known), _POINTS // len(capture))
        chosen = rng.choice(known, count, replace=False) if count else known
        points.append(capture.points_W(view).reshape(-1, 3)[chosen])
        colors.append(capture.rgb[view].reshape(-1, 3)[chosen])
    return np.concatenate(points), np.concatenate(colors)
