"""The tables of the study: verdicts beside the truth."""

from collections.abc import Sequence

import numpy as np
from rich.table import Table
from scipy.stats import rankdata

from apps.studies.counting import share_with_interval, upper_limit
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
    """Words what the commands say of a capture and its map.

    Args:
        result: A trial that succeeded.
    """
    if result.defects:
        return "refused: " + ", ".join(result.defects)
    words = "runs" if result.is_runnable else "too wrong to run"
    return ", ".join([words, *dict.fromkeys(result.warnings)])


def summary(results: Sequence[Result]) -> list[str]:
    """Words what the study found, a line each.

    Args:
        results: All trials.
    """
    good = [r for r in results if not r.error]
    lines = [f"{len(good)} of {len(results)} trials without an error"]
    if not good:
        return lines
    counts = np.array([_kept(r) for r in good])
    share, low, high = share_with_interval(counts)
    lines += [
        f"distances not too large: {100 * share:.3f} %"
        f" ({100 * low:.3f} to {100 * high:.3f}) of {counts[:, 1].sum()}, the"
        f" worst by {_mm(max(r.all.worst for r in good if r.all))} mm",
        f"rank correlation of verdict and truth: {correlation(good):.2f}",
        _below("called safe below", good),
        _below("of those that run", [r for r in good if r.is_runnable]),
    ]
    exact = [r for r in good if not r.wrong]
    lines.append(
        f"exact captures that run: {sum(r.is_runnable for r in exact)} of"
        f" {len(exact)}"
    )
    return lines + _labels(good)


def correlation(results: Sequence[Result]) -> float:
    """Returns Spearman's rank correlation of verdicts and true errors.

    Args:
        results: Trials that succeeded; of fewer than three it is NaN.
    """
    if len(results) < 3:
        return np.nan
    verdict = rankdata([r.verdict for r in results])
    truth = rankdata([r.all.worst for r in results if r.all])
    return float(np.corrcoef(verdict, truth)[0, 1])


def _below(words: str, results: Sequence[Result]) -> str:
    if not results:
        return f"{words}: none"
    count = sum(r.is_below for r in results)
    return (
        f"{words} the true error: {count} of {len(results)} (at most"
        f" {100 * upper_limit(count, len(results)):.1f} %)"
    )


def _kept(result: Result) -> tuple[int, int]:
    assert result.all is not None
    return result.all.count - result.all.exceeded, result.all.count


def _labels(results: Sequence[Result]) -> list[str]:
    """What is nearest, and how many distances to it are not too large."""
    lines = []
    for label in sorted({name for r in results for name in r.by_label}):
        found = [r.by_label[label] for r in results if label in r.by_label]
        count = sum(each.count for each in found)
        kept = count - sum(each.exceeded for each in found)
        worst = max(each.worst for each in found)
        lines.append(
            f"  {label}: {100 * kept / count:.3f} % of {count}, the worst by"
            f" {_mm(worst)} mm"
        )
    return lines


def _mm(length: float) -> str:
    return f"{1e3 * length:.1f}"
