"""The tables of the study: frequency and looseness of the bound."""

from collections.abc import Sequence

import numpy as np
from rich.table import Table

from apps.studies.counting import share_with_interval, upper_limit
from apps.studies.map_bound.trial import Result


def coverage(
    results: Sequence[Result], seed: int = 0
) -> tuple[float, float, float]:
    """Computes the fraction of distances that are not too large.

    Args:
        results: The trials that succeeded.
        seed: Seed of the bootstrap over scenes.

    Returns:
        The fraction of all distances, and the bounds of its 95 % interval.
    """
    counts = np.array([(r.queries - r.exceeded, r.queries) for r in results])
    return share_with_interval(counts, seed)


def exceeding_scenes(results: Sequence[Result]) -> tuple[int, float]:
    """Counts the scenes whose over-estimate exceeds their bound.

    Args:
        results: The trials that succeeded.

    Returns:
        Their number, and the upper limit of their probability.
    """
    count = sum(r.over > r.bound for r in results)
    return count, upper_limit(count, len(results))


def summary(results: Sequence[Result]) -> list[str]:
    """Summarises the study, one line each.

    Args:
        results: All trials.
    """
    good = [r for r in results if not r.error]
    lines = [f"{len(good)} of {len(results)} trials without an error"]
    if not good:
        return lines
    share, low, high = coverage(good)
    count, limit = exceeding_scenes(good)
    bound = np.array([r.bound for r in good])
    over = np.array([r.over for r in good])
    loose = np.array([r.looseness[0] for r in good])
    lines += [
        f"distances not too large: {100 * share:.4f} %"
        f" ({100 * low:.4f} to {100 * high:.4f}) of"
        f" {sum(r.queries for r in good)}, the worst by"
        f" {1e3 * max(r.worst for r in good):.1f} mm",
        f"scenes that exceed their bound: {count} of {len(good)}"
        f" (at most {100 * limit:.1f} %)",
        f"bound {1e3 * np.median(bound):.1f} mm, largest over-estimate"
        f" {1e3 * np.median(over):.1f} mm, a disc's own uncertainty"
        f" {1e3 * np.median([r.medium for r in good]):.1f} mm (medians)",
        f"distances are too small by {1e3 * np.median(loose):.1f} mm (median"
        " of the scenes' medians)",
    ]
    return lines + _poses(good)


def _poses(results: Sequence[Result]) -> list[str]:
    """Errors of poses and scale before and after, by kind of disturbance."""
    lines = []
    for name, unit, size in (
        ("position", "mm", 1e3),
        ("shape", "mm", 1e3),
        ("rotation", "deg", 180 / np.pi),
        ("scale", "%", 100),
    ):
        before = size * np.abs([getattr(r.before, name) for r in results])
        after = size * np.abs([getattr(r.after, name) for r in results])
        off = before > 1e-6
        if off.any():
            lines.append(
                f"{name} of {off.sum()} disturbed captures:"
                f" {np.median(before[off]):.2f} -> {np.median(after[off]):.2f}"
                f" {unit} (median), {np.percentile(before[off], 90):.2f} ->"
                f" {np.percentile(after[off], 90):.2f} {unit} (90 %)"
            )
    return lines


def table(results: Sequence[Result]) -> Table:
    """Lists the trials.

    Args:
        results: All trials.
    """
    shown = Table("case", "over", "bound", "exceeded", "loose", "shape", "s")
    for r in results:
        if r.error or r.before is None or r.after is None:
            shown.add_row(r.key, r.error.splitlines()[-1])
            continue
        shown.add_row(
            r.key,
            f"{1e3 * r.over:.1f}",
            f"{1e3 * r.bound:.1f}",
            f"{r.exceeded}/{r.queries}",
            f"{1e3 * r.looseness[0]:.1f}",
            f"{1e3 * r.before.shape:.1f} -> {1e3 * r.after.shape:.1f}",
            f"{r.seconds[0]:.0f}",
        )
    return shown
