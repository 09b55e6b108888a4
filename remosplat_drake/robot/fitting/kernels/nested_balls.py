"""Divides points into nested balls."""

import math

from remosplat_drake.base.kernels import helper, kernel


@kernel
def divide(tree):
    """Divides points into nested balls, each halved along its longest side.

    Args:
        tree: A packed `PointTree` with the points in any order, and with
            2^d - 1 balls for some d; all of its arrays are filled in.
    """
    points, first, last, right, center, radius = (
        tree.points,
        tree.first,
        tree.last,
        tree.right,
        tree.center,
        tree.radius,
    )
    first[0], last[0] = 0, len(points)
    # Until a ball is visited, `right` holds the number of its balls.
    right[0] = len(first)
    for ball in range(len(first)):
        start, end, size = first[ball], last[ball], right[ball]
        longest, side = 0, -1.0
        for c in range(3):
            lower = upper = points[start, c]
            for i in range(start + 1, end):
                lower = min(lower, points[i, c])
                upper = max(upper, points[i, c])
            center[ball, c] = 0.5 * (lower + upper)
            if upper - lower > side:
                longest, side = c, upper - lower
        square = 0.0
        for i in range(start, end):
            x = points[i, 0] - center[ball, 0]
            y = points[i, 1] - center[ball, 1]
            z = points[i, 2] - center[ball, 2]
            square = max(square, x * x + y * y + z * z)
        radius[ball] = math.sqrt(square)
        if size == 1:
            right[ball] = -1
            continue
        middle = (start + end) // 2
        _halve(points, start, end, middle, longest)
        # The first child and all balls in it precede the second.
        half = size // 2
        right[ball] = ball + 1 + half
        first[ball + 1], last[ball + 1] = start, middle
        first[right[ball]], last[right[ball]] = middle, end
        right[ball + 1] = right[right[ball]] = half


@helper
def _halve(points, start, end, middle, axis):
    """Sorts points so that those from the middle on are not lower (Hoare)."""
    low, high = start, end - 1
    while low < high:
        pivot = points[(low + high) // 2, axis]
        i, j = low, high
        while i <= j:
            while points[i, axis] < pivot:
                i += 1
            while points[j, axis] > pivot:
                j -= 1
            if i <= j:
                for c in range(3):
                    points[i, c], points[j, c] = points[j, c], points[i, c]
                i, j = i + 1, j - 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return
