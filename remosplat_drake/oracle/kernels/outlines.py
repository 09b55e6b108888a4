"""Outlines of projected splats: where in a view their fragments are (numba).

An outline is a quadratic form of the ray (x, y, 1), <= 0 inside; its rows
and columns bound the pixels that need to be looked at.
"""

import numpy as np

from remosplat_drake.oracle.kernels.footprints import inlined, lean

OUTLINE, NEAR = 15, 21
"""Places of the two outlines in the array of a projected splat."""


@lean
def outline(s, rules, cut):
    """Writes the outline weight = cut of a projected splat into s[OUTLINE:].

    It is a quadratic form of the ray, <= 0 inside: entries xx, xy, xz, yy,
    yz, zz.
    """
    inside = s[9] * s[9] + s[10] * s[10] + s[11] * s[11] - cut
    entry = OUTLINE
    for i in range(3):
        for j in range(i, 3):
            ab = s[i] * s[j] + s[3 + i] * s[3 + j]
            cc = s[6 + i] * s[6 + j]
            if rules.is_surfel:
                s[entry] = ab - cut * cc
            else:
                along_i = s[9] * s[i] + s[10] * s[3 + i] + s[11] * s[6 + i]
                along_j = s[9] * s[j] + s[10] * s[3 + j] + s[11] * s[6 + j]
                s[entry] = inside * (ab + cc) - along_i * along_j
            entry += 1


@lean
def near_outline(s, reach):
    """Writes where a disc's plane is nearer than `reach` into s[NEAR:].

    The range of the plane along a ray is height |ray| / C.
    """
    entry = NEAR
    for i in range(3):
        for j in range(i, 3):
            s[entry] = -reach * reach * s[6 + i] * s[6 + j]
            if i == j:
                s[entry] += s[9] * s[9]
            entry += 1


@lean
def row_span(s, rules, at):
    """Returns the first and last image row y that the outline s[at:] meets."""
    xx, xy, xz = s[at], s[at + 1], s[at + 2]
    yy, yz, zz = s[at + 3], s[at + 4], s[at + 5]
    if xx > 0:
        # Where the row's columns have a discriminant >= 0.
        return _quadratic_span(
            xx * yy - xy * xy,
            xx * yz - xy * xz,
            xx * zz - xz * xz,
            s[9] * (s[7] * xx - s[6] * xy) if rules.is_surfel else 0.0,
        )
    if rules.is_surfel:
        # A branch of a hyperbola that opens along x: it is convex, and
        # widest where it leaves the image.
        x = 1.0 if s[9] * s[6] > 0 else -1.0
        return _quadratic_span(
            yy, xy * x + yz, xx + 2 * xz * x + zz, s[9] * s[7]
        )
    return -1.0, 1.0


@inlined
def column_span(s, rules, at, y):
    """Returns the columns x of row y inside an outline; empty if low > high."""
    return _quadratic_span(
        s[at],
        s[at + 1] * y + s[at + 2],
        (s[at + 3] * y + 2 * s[at + 4]) * y + s[at + 5],
        s[9] * s[6] if rules.is_surfel else 0.0,
    )


@lean
def _quadratic_span(tt, t, one, side):
    """Where tt x^2 + 2 t x + one <= 0, as an interval that holds it all.

    Where tt < 0 that is two half-lines: one before and one behind the
    camera. `side` > 0 selects the upper one, < 0 the lower one; 0 and forms
    that are linear but for rounding give the whole image.
    """
    square = t * t - tt * one
    if abs(tt) <= 1e-9 * (abs(t) + abs(one)):
        return -1.0, 1.0
    if tt > 0:
        if square < 0:
            return 2.0, -2.0
        half = np.sqrt(square)
        return (-t - half) / tt, (-t + half) / tt
    if square < 0 or side == 0:
        return -1.0, 1.0
    half = np.sqrt(square)
    if side > 0:
        return (-t - half) / tt, 1.0
    return -1.0, (-t + half) / tt
