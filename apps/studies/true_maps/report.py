"""The tables of the study: verdicts compared with the truth."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from rich.table import Table
from scipy.stats import rankdata

from apps.studies.counting import share_with_interval, upper_limit
from apps.studies.true_maps.judge import Excess
from apps.studies.true_maps.trial import Result


def table(results: Sequence[Result]) -> Table:
    """Lists the trials; lengths are in millimetres.

    Args:
        results: All trials.
    """
    shown = Table("case")
    for heading in (
        "verdict",
        "truth",
        "over",
        "too large",
        "thin",
        "disc",
        "shape",
        "says",
        "s",
    ):
        shown.add_column(heading, justify="right")
    for r in results:
        if r.error:
            shown.add_row(r.key, r.error.splitlines()[-1])
            continue
        assert r.all and r.thin and r.before and r.after
        shown.add_row(
            r.key,
            _mm(r.verdict),
            _mm(r.all.worst),
            _mm(r.all.over),
            f"{r.all.exceeded}/{r.all.count}",
            _mm(r.thin.worst),
            _mm(r.medium),
            f"{_mm(r.before.shape)} -> {_mm(r.after.shape)}",
            says(r),
            f"{sum(r.seconds):.0f}",
        )
    return shown


def says(result: Result) -> str:
    """Summarises the commands' messages about a capture and its map.

    Args:
        result: A trial that succeeded.
    """
    if result.defects:
        return "refused: " + ", ".join(result.defects)
    words = "runs" if result.is_runnable else "too wrong to run"
    return ", ".join([words, *dict.fromkeys(result.warnings)])


def summary(results: Sequence[Result]) -> list[str]:
    """Summarises the study, one line each.

    Args:
        results: All trials.
    """
    good = [r for r in results if not r.error]
    lines = [f"{len(good)} of {len(results)} trials without an error"]
    if not good:
        return lines
    lines += [
        _not_too_large("distances", [r.all for r in good if r.all]),
        _not_too_large(
            "those to what is under a pixel wide",
            [r.thin for r in good if r.thin and r.thin.count],
        ),
        f"rank correlation of the verdict: {correlation(good, 'over'):.2f} with"
        " the largest over-estimate,"
        f" {correlation(good, 'worst'):.2f} with the largest excess",
        _below("called safe below the true error", good),
        _below("of those that run", [r for r in good if r.is_runnable]),
    ]
    exact = [r for r in good if not r.wrong]
    lines.append(
        f"exact captures that run: {sum(r.is_runnable for r in exact)} of"
        f" {len(exact)}"
    )
    return lines + _labels(good)


def correlation(
    results: Sequence[Result], error: Literal["over", "worst"]
) -> float:
    """Returns Spearman's rank correlation of verdicts and true errors.

    Args:
        results: Trials that succeeded; NaN for fewer than three.
        error: The field of `Excess` that is the true error.
    """
    if len(results) < 3:
        return np.nan
    verdict = rankdata([r.verdict for r in results])
    truth = rankdata([getattr(r.all, error) for r in results])
    return float(np.corrcoef(verdict, truth)[0, 1])


def _not_too_large(words: str, found: Sequence[Excess]) -> str:
    """Share of distances that are not too large, with its interval."""
    if not found:
        return f"{words}: none"
    counts = np.array([(e.count - e.exceeded, e.count) for e in found])
    share, low, high = share_with_interval(counts)
    return (
        f"{words} not too large: {100 * share:.3f} % ({100 * low:.3f} to"
        f" {100 * high:.3f}) of {counts[:, 1].sum()}, the worst by"
        f" {_mm(max(e.worst for e in found))} mm"
    )


def _below(words: str, results: Sequence[Result]) -> str:
    """Number of verdicts below the truth, and a bound of their frequency."""
    if not results:
        return f"{words}: none"
    count = sum(r.is_below for r in results)
    limit = upper_limit(count, len(results))
    return f"{words}: {count} of {len(results)} (at most {100 * limit:.1f} %)"


def _labels(results: Sequence[Result]) -> list[str]:
    """Share of distances that are not too large, by label."""
    return [
        _not_too_large(
            f"  {label}",
            [r.by_label[label] for r in results if label in r.by_label],
        )
        for label in sorted({name for r in results for name in r.by_label})
    ]


def _mm(length: float) -> str:
    return f"{1e3 * length:.1f}"
