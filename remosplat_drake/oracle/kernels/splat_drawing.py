"""Drawing one splat into one depth view, as far as it matters (numba)."""

import numpy as np

from remosplat_drake.oracle.depth_sensor import FILTER_SCALE, N_VIEWS
from remosplat_drake.oracle.kernels.footprints import (
    fragment,
    fragment_alpha,
    inlined,
    lean,
    meet_plane,
    pixel_span,
    splat_margin,
    whiten,
)
from remosplat_drake.oracle.kernels.outlines import (
    NEAR,
    OUTLINE,
    column_span,
    near_outline,
    outline,
    row_span,
)
from remosplat_drake.oracle.kernels.pixel_lists import (
    DEFERRED,
    FRAGMENTS,
    ROUNDING,
    add_fragment,
    has_median,
    median_range,
    settle,
)
from remosplat_drake.oracle.kernels.windows import (
    WHOLE,
    disc_window,
    is_empty,
)

_TALL = 6
"""Number of rows from which on a splat is deferred; twice as many once the
view has a nearest pixel, since less is drawn in vain then."""

_LARGE = 5
"""Radius in the image from which on a disc's window pays [px]."""

_ALL, _GRID, _REST = range(3)
"""Which pixels are drawn: all, those of the grid, or the others."""

_NOTHING = (0, -1, 0, -1)


@inlined
def draw(splats, k, rules, view, canvas, nearest_only):
    """Adds a splat's fragments nearer than the limit of a view.

    Where these may be many, only those of the grid's pixels are added, and the
    splat is deferred.

    Returns:
        Whether the canvas has room for them.
    """
    window, dot = _begin(splats, k, rules, view, canvas)
    rows = window[1] - window[0] + 1
    if rows <= 0:
        return True
    if not _has_room(canvas):
        return False
    if rows < (_TALL if canvas.best_pixel[view] < 0 else 2 * _TALL):
        _draw_rows(
            splats, k, rules, view, canvas, window, dot, _ALL, nearest_only
        )
        return True
    deferred = canvas.count[DEFERRED]
    canvas.deferred[deferred] = k * N_VIEWS + view
    canvas.count[DEFERRED] += 1
    _draw_rows(splats, k, rules, view, canvas, window, dot, _GRID, nearest_only)
    return True


@inlined
def draw_the_rest(splats, k, rules, view, canvas, nearest_only):
    """Adds the fragments of a deferred splat that are not on the grid.

    Returns:
        Whether the canvas has room for them.
    """
    window, dot = _begin(splats, k, rules, view, canvas)
    if not _has_room(canvas):
        return False
    _draw_rows(splats, k, rules, view, canvas, window, dot, _REST, nearest_only)
    return True


@inlined
def _has_room(canvas):
    """Whether the canvas has room for one more splat in one view."""
    return canvas.count[FRAGMENTS] + len(canvas.length) <= len(
        canvas.link
    ) and canvas.count[DEFERRED] < len(canvas.deferred)


@inlined
def _begin(splats, k, rules, view, canvas):
    """Projects a splat, and finds the rows and columns that bound it.

    Returns:
        The first and last row and the first and last column; and the dot that
        the low-pass filter puts on the splat's centre, as x, y and half its
        width: negative if there is none.
    """
    s, views = canvas.projection, canvas.views
    whiten(splats.records, k, views.p_WS, views.R_WV[view], s)
    cut = splats.records[k, 13]
    reach = canvas.limit[view] + splat_margin(splats, k)
    dot = (0.0, 0.0, -1.0)
    if rules.low_pass_filter and s[14] > rules.near:
        half = 2 * np.sqrt(cut / FILTER_SCALE) / rules.resolution
        dot = (s[12] / s[14], s[13] / s[14], half)
    window = WHOLE
    if rules.is_surfel:
        if not rules.low_pass_filter and (
            splats.records[k, 14] * rules.resolution > 2 * _LARGE * s[14]
        ):
            window = disc_window(s, cut, reach, rules.near)
            if is_empty(window):
                return _NOTHING, dot
        meet_plane(s)
    outline(s, rules, cut)
    low, high = row_span(s, rules, OUTLINE)
    if rules.is_surfel:
        near_outline(s, reach)
        y_near, y_far = row_span(s, rules, NEAR)
        low, high = max(low, y_near), min(high, y_far)
    low, high = max(low, window[2]), min(high, window[3])
    if dot[2] >= 0:
        low, high = _with_dot(low, high, dot[1], dot[2])
    rows = pixel_span(low, high, rules.resolution)
    columns = pixel_span(window[0], window[1], rules.resolution)
    if columns[0] > columns[1]:
        return _NOTHING, dot
    return (rows[0], rows[1], columns[0], columns[1]), dot


@inlined
def _draw_rows(splats, k, rules, view, canvas, window, dot, part, nearest_only):
    """Adds the projected splat's fragments in a part of its pixels."""
    s = canvas.projection
    places, place_from = canvas.every, canvas.every
    if part == _GRID:
        places, place_from = canvas.grid, canvas.grid_from
    first_row, last_row, first_column, last_column = window
    if first_row > last_row:
        return
    for i in range(place_from[first_row], place_from[last_row + 1]):
        row = places[i]
        first, last = _columns(s, rules, canvas.axis[row], dot)
        first, last = max(first, first_column), min(last, last_column)
        if first > last:
            continue
        on_grid = canvas.grid[canvas.grid_from[row]] == row
        for j in range(place_from[first], place_from[last + 1]):
            column = places[j]
            if (
                part == _REST
                and on_grid
                and canvas.grid[canvas.grid_from[column]] == column
            ):
                continue
            _draw_pixel(
                splats, k, rules, view, canvas, row, column, nearest_only
            )


@inlined
def _columns(s, rules, y, dot):
    """Finds the first and last column of row y that a splat meets."""
    x_low, x_high = -1.0, 1.0
    if rules.is_surfel:
        x_low, x_high = column_span(s, rules, NEAR, y)
    if x_low <= x_high:
        x_left, x_right = column_span(s, rules, OUTLINE, y)
        x_low, x_high = max(x_low, x_left), min(x_high, x_right)
    if abs(y - dot[1]) <= dot[2]:
        x_low, x_high = _with_dot(x_low, x_high, dot[0], dot[2])
    return pixel_span(x_low, x_high, rules.resolution)


@inlined
def _draw_pixel(splats, k, rules, view, canvas, row, column, nearest_only):
    """Adds one fragment, and judges its pixel."""
    pixel = row * rules.resolution + column
    z, weight = fragment(
        canvas.projection, rules, canvas.axis[column], canvas.axis[row]
    )
    length = canvas.length[pixel]
    margin = splat_margin(splats, k)
    reach = z * length - margin
    limit = canvas.limit[view]
    alpha = 0.0
    if reach < limit:
        alpha = fragment_alpha(
            z, weight, splats.records[k, 12], rules, margin / length
        )
    if alpha > 0:
        pixel += view * len(canvas.length)
        add_fragment(canvas, pixel, reach, alpha)
        if has_median(canvas, pixel, rules) and (
            1 - canvas.total[pixel] >= rules.alpha_cutoff - ROUNDING
        ):
            median, accumulated = median_range(canvas, pixel, rules, limit)
            if median < limit and accumulated >= rules.alpha_cutoff:
                settle(canvas, median, pixel, nearest_only)


@lean
def _with_dot(low, high, center, half):
    """An interval, empty if low > high, enlarged by center +- half."""
    if low > high:
        return center - half, center + half
    return min(low, center - half), max(high, center + half)
