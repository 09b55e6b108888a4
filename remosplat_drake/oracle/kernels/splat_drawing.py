"""Draws the parts of splats that can change the result into depth views.

The kernels (Numba) collect eight splats for a view, and project them together,
one splat per SIMD lane. For each splat, they compute the bounds of eight rows
of pixels together, and draw four pixels of a row together.
"""

from remosplat_drake.base.lanes import (
    FEW,
    WIDTH,
    columns_of,
    exponential,
    few_lanes_from,
    first_lanes,
    greatest,
    in_all,
    lanes_from,
    least,
    lowest_bit,
    magnitude,
    places_of,
    root,
    where,
    write_lanes,
)
from remosplat_drake.oracle.depth_sensor import FILTER_SCALE, N_VIEWS
from remosplat_drake.oracle.kernels.footprints import (
    fragment,
    inlined,
    is_within,
    lean,
    meet_plane,
    pixel_span,
    whiten,
)
from remosplat_drake.oracle.kernels.outlines import (
    column_span,
    near_outline,
    outline,
    row_span,
)
from remosplat_drake.oracle.kernels.pixel_layers import EVERY, GRID
from remosplat_drake.oracle.kernels.pixel_runs import (
    CANDIDATES,
    DEFERRED,
    ROUNDING,
    add_run,
    gather,
    has_capacity,
    median_range,
    settle,
)
from remosplat_drake.oracle.kernels.windows import disc_window

_TALL = 6
"""Least number of pixel rows of a splat that is deferred. Of a deferred splat,
only the pixels on the coarse grid are drawn at first. If the view already has a
nearest pixel, the threshold is twice this number, since drawing all pixels then
draws fewer unnecessary ones."""

ALL, _COARSE, REST = range(3)
"""Parts of a splat's pixels that are drawn: all pixels, those of the coarse
grid, or those that are not on the grid."""

# Offsets in the values of a projected splat: its linear forms, two outlines,
# the disc of the low-pass filter, and the first and last row and column of its
# bounds.
_FORMS, _OUTLINE, _NEAR, _DOT, _BOUNDS = 0, 15, 21, 27, 30


@lean
def draw(splats, rules, canvas, view, k, part):
    """Collects a splat for a view, and draws eight collected splats at once.

    Arguments and result are those of `draw_waiting`; k is the splat's index in
    the records.
    """
    n = canvas.ready[view]
    canvas.places[view, n] = k
    canvas.ready[view] = n + 1
    return n + 1 < WIDTH or draw_waiting(splats, rules, canvas, view, part)


@lean
def draw_waiting(splats, rules, canvas, view, part):
    """Draws the splats that are collected for a view.

    Args:
        splats: The `Footprints`.
        rules: The sensor's `Rules`.
        canvas: The `Canvas`.
        view: Index of the view.
        part: ALL or REST. With ALL, splats that span many rows are deferred,
            and only their grid pixels are drawn.

    Returns:
        False if the canvas has no capacity for the splats.
    """
    if not has_capacity(canvas, rules):
        return False
    n, places = canvas.ready[view], canvas.places[view]
    canvas.ready[view] = 0
    places[n:] = places[0]
    tall = _TALL if canvas.best_pixel[view] < 0 else 2 * _TALL
    left, seen = _project(splats, rules, canvas, view) & ((1 << n) - 1), 0
    while left:
        lane = lowest_bit(left)
        left &= left - 1
        canvas.parts[lane] = part
        if part == ALL and _count_rows(canvas, lane) >= tall:
            canvas.parts[lane] = _COARSE
            number = canvas.count[DEFERRED]
            canvas.deferred[number] = places[lane] * N_VIEWS + view
            canvas.count[DEFERRED] = number + 1
        if _find_columns(rules, canvas, lane):
            seen |= 1 << lane
    while seen:
        lane = lowest_bit(seen)
        seen &= seen - 1
        _draw_pixels(splats, rules, canvas, view, lane)
    return True


@inlined
def _project(splats, rules, canvas, view):
    """Projects the collected splats, and bounds the pixels of each.

    Returns:
        An integer whose bit i is set if splat i may be visible.
    """
    p, at = canvas.views.p_WS, canvas.projections
    record = columns_of(splats.records, canvas.places[view])
    center = record[0] - p[0], record[1] - p[1], record[2] - p[2]
    cut, reach = record[13], canvas.limit[view] + record[15]
    s = whiten(center, record[3:12], canvas.views.R_WV[view])
    x_low, x_high = in_all(-1.0), in_all(1.0)
    y_low, y_high = in_all(-1.0), in_all(1.0)
    if rules.is_surfel:
        if not rules.low_pass_filter:
            x_low, x_high, y_low, y_high = disc_window(
                s, cut, reach, rules.near
            )
        s = meet_plane(s)
    edge = outline(s, rules, cut)
    low, high = row_span(s, rules, edge)
    y_low, y_high = greatest(low, y_low), least(high, y_high)
    if rules.is_surfel:
        near_edge = near_outline(s, reach)
        low, high = row_span(s, rules, near_edge)
        y_low, y_high = greatest(low, y_low), least(high, y_high)
        _keep(at, _NEAR, near_edge)
    if rules.low_pass_filter:
        half = 2 * root(cut / FILTER_SCALE) / rules.resolution
        half = where(s[14] > rules.near, half, -1.0)
        dot = s[12] / s[14], s[13] / s[14], half
        y_low, y_high = _with_dot(y_low, y_high, dot[1], half)
        _keep(at, _DOT, dot)
    rows = pixel_span(y_low, y_high, rules.resolution)
    columns = pixel_span(x_low, x_high, rules.resolution)
    _keep(at, _FORMS, s)
    _keep(at, _OUTLINE, edge)
    _keep(at, _BOUNDS, rows + columns)
    return places_of((rows[0] <= rows[1]) & (columns[0] <= columns[1]))


@inlined
def _keep(projections, at, values):
    for i in range(len(values)):
        write_lanes(projections, (at + i) * WIDTH, values[i])


@inlined
def _three(canvas, at, lane):
    """Returns three consecutive values of one of the projected splats."""
    kept = canvas.projections
    return kept[at, lane], kept[at + 1, lane], kept[at + 2, lane]


@inlined
def _six(canvas, at, lane):
    return _three(canvas, at, lane) + _three(canvas, at + 3, lane)


@inlined
def _forms(canvas, lane):
    return (
        _six(canvas, _FORMS, lane)
        + _six(canvas, _FORMS + 6, lane)
        + _three(canvas, _FORMS + 12, lane)
    )


@inlined
def _count_rows(canvas, lane):
    kept = canvas.projections
    return kept[_BOUNDS + 1, lane] - kept[_BOUNDS, lane] + 1


@inlined
def _layer_and_rows(canvas, lane):
    """Returns the layer to draw, and the first and end places of its rows."""
    layer = GRID if canvas.parts[lane] == _COARSE else EVERY
    place_from, kept = canvas.layers.place_from, canvas.projections
    first, last = int(kept[_BOUNDS, lane]), int(kept[_BOUNDS + 1, lane])
    return layer, place_from[layer, first], place_from[layer, last + 1]


@lean
def _find_columns(rules, canvas, lane):
    """Computes the columns of a projected splat in each of its rows.

    Returns:
        Whether the splat covers a pixel in any row.
    """
    s = _forms(canvas, lane)
    edge, near_edge = _six(canvas, _OUTLINE, lane), _six(canvas, _NEAR, lane)
    dot = _three(canvas, _DOT, lane)
    first_column = canvas.projections[_BOUNDS + 2, lane]
    last_column = canvas.projections[_BOUNDS + 3, lane]
    layer, begin, end = _layer_and_rows(canvas, lane)
    axis = layer * canvas.layers.axis.shape[1]
    chunk, any_met = 0, 0
    while begin < end:
        y = lanes_from(canvas.layers.axis, axis + begin)
        low, high = column_span(s, rules, edge, y)
        if rules.is_surfel:
            near_low, near_high = column_span(s, rules, near_edge, y)
            low, high = greatest(low, near_low), least(high, near_high)
        if rules.low_pass_filter:
            half = where(magnitude(y - dot[1]) <= dot[2], dot[2], -1.0)
            low, high = _with_dot(low, high, dot[0], half)
        first, last = pixel_span(low, high, rules.resolution)
        first, last = greatest(first, first_column), least(last, last_column)
        at = 2 * WIDTH * (lane * canvas.met.shape[1] + chunk)
        write_lanes(canvas.spans, at, first)
        write_lanes(canvas.spans, at + WIDTH, last)
        met = places_of((first <= last) & first_lanes(end - begin, y))
        canvas.met[lane, chunk] = met
        any_met |= met
        begin += WIDTH
        chunk += 1
    return any_met != 0


@lean
def _draw_pixels(splats, rules, canvas, view, lane):
    """Adds a projected splat's fragments in the part of its pixels to draw."""
    s, k = _forms(canvas, lane), canvas.places[view, lane]
    layer, begin, end = _layer_and_rows(canvas, lane)
    place_from = canvas.layers.place_from
    chunk = 0
    while begin < end:
        met = canvas.met[lane, chunk]
        while met:
            j = lowest_bit(met)
            met &= met - 1
            first = int(canvas.spans[lane, chunk, 0, j])
            last = int(canvas.spans[lane, chunk, 1, j])
            _draw_row(
                splats,
                rules,
                canvas,
                view,
                k,
                s,
                canvas.parts[lane],
                layer,
                begin + j,
                place_from[layer, first],
                place_from[layer, last + 1],
            )
        begin += WIDTH
        chunk += 1


@inlined
def _draw_row(splats, rules, canvas, view, k, s, part, layer, row, first, end):
    """Adds a splat's fragments in the pixels of a row from `first` to `end`."""
    layers = canvas.layers
    opacity, margin = splats.records[k, 12], splats.records[k, 15]
    axis, y = layer * layers.axis.shape[1], layers.axis[layer, row]
    row_in_view = layers.index[layer, row]
    skips_grid = part == REST and layers.place[GRID, row_in_view] >= 0
    for begin in range(first, end, FEW):
        x = few_lanes_from(layers.axis, axis + begin)
        length = few_lanes_from(
            layers.length, layers.length_from[layer, row] + begin
        )
        z, weight = fragment(s, rules, x, y)
        reach, shift = z * length - margin, 0.0 * length
        if margin > 0:
            shift = margin / length
        alpha = opacity * exponential(-0.5 * weight)
        seen = (
            is_within(z, weight, rules, shift)
            & (alpha >= rules.min_alpha)
            & (reach < canvas.limit[view])
            & first_lanes(end - begin, x)
        )
        if skips_grid:
            seen = seen & (few_lanes_from(layers.beside_grid, begin) > 0)
        if places_of(seen):
            alpha = where(seen, alpha, 0.0)
            number = view * rules.resolution + row_in_view
            light = add_run(canvas, rules, number, layer, begin, reach, alpha)
            _judge_run(rules, canvas, number, layer, begin, alpha, light)


@inlined
def _judge_run(rules, canvas, row, layer, begin, alpha, light):
    """Tests whether changed pixels become the nearest of the view."""
    before, after = light
    index, first = canvas.layers.index[layer], row * rules.resolution
    median_at = rules.transmittance + ROUNDING
    opaque_at = 1 - rules.alpha_cutoff + ROUNDING
    is_met = alpha > 0
    new = places_of(is_met & (before > median_at) & (after <= median_at))
    while new:
        number = canvas.count[CANDIDATES]
        canvas.candidates[number] = first + index[begin + lowest_bit(new)]
        canvas.count[CANDIDATES] = number + 1
        new &= new - 1
    # `light` is negative only for pixels that are known to reach
    # `alpha_cutoff`.
    near = places_of(is_met & (after <= opaque_at) & (after >= -median_at))
    while near:
        _judge(rules, canvas, first + index[begin + lowest_bit(near)])
        near &= near - 1


@lean
def _judge(rules, canvas, pixel):
    """Records a pixel if it is complete and has a nearer median."""
    limit = canvas.limit[pixel // (rules.resolution * rules.resolution)]
    n, all_clear, near_clear = gather(canvas, rules, pixel, limit)
    if 1 - all_clear < rules.alpha_cutoff:
        return
    canvas.light[pixel] = -near_clear
    if near_clear <= rules.transmittance + ROUNDING:
        median = median_range(canvas, rules, n)
        if median < limit:
            settle(canvas, rules, median, pixel)


@inlined
def _with_dot(low, high, center, half):
    """Extends intervals [low, high] by center +- half, if half >= 0."""
    is_empty, has_dot = low > high, half >= 0
    dot_low, dot_high = center - half, center + half
    with_low = where(is_empty, dot_low, least(low, dot_low))
    with_high = where(is_empty, dot_high, greatest(high, dot_high))
    return where(has_dot, with_low, low), where(has_dot, with_high, high)
