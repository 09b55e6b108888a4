"""Drawing one splat into one depth view, as far as it matters (numba)."""

import numpy as np

from remosplat_drake.oracle.depth_sensor import FILTER_SCALE, N_VIEWS
from remosplat_drake.oracle.kernels.footprints import (
    fragment,
    fragment_alpha,
    inlined,
    lean,
    pixel_span,
    project,
    splat_margin,
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
    ROUNDING,
    add_fragment,
    has_median,
    median_range,
)


@inlined
def draw(splats, k, rules, views, view, canvas, stamp, nearest_only):
    """Adds a splat's fragments nearer than the nearest pixel of a view."""
    s = canvas.projection
    resolution = rules.resolution
    best = canvas.best[view]
    cut, opacity = splats.records[k, 13], splats.records[k, 12]
    margin = splat_margin(splats, k)
    project(splats.records, k, rules, views.p_WS, views.R_WV[view], s)
    outline(s, rules, cut)
    y_low, y_high = row_span(s, rules, OUTLINE)
    if rules.is_surfel:
        near_outline(s, best + margin)
        y_near, y_far = row_span(s, rules, NEAR)
        y_low, y_high = max(y_low, y_near), min(y_high, y_far)
    # The dot that the low-pass filter puts on the splat's centre.
    dot, x_dot, y_dot = -1.0, 0.0, 0.0
    if rules.low_pass_filter and s[14] > rules.near:
        dot = 2 * np.sqrt(cut / FILTER_SCALE) / resolution
        x_dot, y_dot = s[12] / s[14], s[13] / s[14]
        y_low, y_high = _with_dot(y_low, y_high, y_dot, dot)
    first_row, last_row = pixel_span(y_low, y_high, resolution)
    for row in range(first_row, last_row + 1):
        y = (row + 0.5) * 2 / resolution - 1
        x_low, x_high = -1.0, 1.0
        if rules.is_surfel:
            x_low, x_high = column_span(s, rules, NEAR, y)
        if x_low <= x_high:
            x_left, x_right = column_span(s, rules, OUTLINE, y)
            x_low, x_high = max(x_low, x_left), min(x_high, x_right)
        if abs(y - y_dot) <= dot:
            x_low, x_high = _with_dot(x_low, x_high, x_dot, dot)
        first, last = pixel_span(x_low, x_high, resolution)
        for column in range(first, last + 1):
            x = (column + 0.5) * 2 / resolution - 1
            pixel = row * resolution + column
            z, weight = fragment(s, rules, x, y)
            length = canvas.length[pixel]
            reach = z * length - margin
            if not reach < best:
                continue
            alpha = fragment_alpha(z, weight, opacity, rules, margin / length)
            if alpha == 0:
                continue
            pixel += view * len(canvas.length)
            add_fragment(canvas, pixel, stamp, reach, alpha)
            if has_median(canvas, pixel, rules) and (
                1 - canvas.total[pixel] >= rules.alpha_cutoff - ROUNDING
            ):
                median, accumulated = median_range(canvas, pixel, rules, best)
                if median < best and accumulated >= rules.alpha_cutoff:
                    settle(canvas, view, median, pixel, nearest_only)
                    best = median


@lean
def settle(canvas, view, reach, pixel, nearest_only):
    """Makes a complete pixel the nearest one of its view."""
    canvas.best[view], canvas.best_pixel[view] = reach, pixel
    if nearest_only:
        # Of equal views the first is meant, whichever is met first.
        limit = np.nextafter(reach, np.inf)
        for other in range(N_VIEWS):
            if canvas.best[other] > limit:
                canvas.best[other], canvas.best_pixel[other] = limit, -1


@lean
def _with_dot(low, high, center, half):
    """An interval, empty if low > high, enlarged by center +- half."""
    if low > high:
        return center - half, center + half
    return min(low, center - half), max(high, center + half)
