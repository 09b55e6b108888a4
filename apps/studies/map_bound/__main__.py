"""Tests the bound on a map's error with disturbed captures.

Scenes are rendered, their captures disturbed (poses, drift, scale, sensor),
reconstructed without the truth, and compared with it. The constants of
`reconstruction/uncertainty/bound.py` were chosen on the families and seeds of
`--split calibration`, and are reported on those of `--split evaluation`.
"""

import argparse
import sys
from collections.abc import Sequence

from apps.studies import case_study
from apps.studies.case_study import NAMED as NAMED_SPLIT
from apps.studies.case_study import CaseStudy
from apps.studies.command_line import study_main
from apps.studies.map_bound.case import Case, draw_case
from apps.studies.map_bound.closed_loop import attack_case
from apps.studies.map_bound.disturbance import NAMED
from apps.studies.map_bound.report import summary, table
from apps.studies.map_bound.trial import failed, restored, run_trial

SPLITS = {
    "calibration": (("table", "bookshelf2"), 1000),
    "evaluation": (("bookshelf", "table2", "posts"), 5000),
}
"""Families of scenes, and the first seed, by the name of the split."""

VIEWS = 40
"""Number of views of the named disturbances."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    case_study.add_arguments(parser, "map_bound", list(SPLITS))


def cases(split: str, first: int, count: int) -> list[Case]:
    """Returns cases of a split, in order.

    Args:
        split: Name of the split, or `named`.
        first: Number of the first case.
        count: Number of cases.
    """
    if split == NAMED_SPLIT:
        drawn = [
            Case(family, 1, VIEWS, what)
            for what in NAMED.values()
            for family in ("table", "bookshelf")
        ]
        return drawn[first : first + count]
    families, start = SPLITS[split]
    numbers = range(first, first + count)
    return [draw_case(families[i % len(families)], start + i) for i in numbers]


STUDY = CaseStudy(
    "map_bound",
    cases,
    run_trial,
    failed,
    restored,
    table,
    summary,
    attacked=cases,
    attack=attack_case,
)


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("map_bound", __doc__, add_arguments, STUDY.run, argv)


if __name__ == "__main__":
    sys.exit(main())
