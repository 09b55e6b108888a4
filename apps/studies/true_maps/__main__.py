"""Tests the verdicts on maps of hand-held cameras in triangle-mesh scenes.

Captures of rooms of triangle meshes are simulated by ray casting, along the
path of a hand, with the errors of real sensors and trackers. Maps, made without
the truth, and the verdicts of their quality reports are compared with the
truth. Choose constants with `--split develop`; report results of `--split
frozen`.
"""

import argparse
import sys
from collections.abc import Sequence

from rich.console import Console

from apps.studies import case_study
from apps.studies.case_study import NAMED as NAMED_SPLIT
from apps.studies.case_study import CaseStudy
from apps.studies.command_line import study_main
from apps.studies.true_maps import report, rods
from apps.studies.true_maps.case import Case, draw_case
from apps.studies.true_maps.closed_loop import attack_case
from apps.studies.true_maps.disturbance import EXACT, NAMED
from apps.studies.true_maps.trial import failed, restored, run_trial
from remosplat_drake.base.progress import Progress

SPLITS = {"develop": 100_000, "frozen": 500_000}
"""First seeds of scenes, paths and disturbances, by the name of the split."""

NAMED_SEEDS = (1, 3)
"""Seeds of the scenes of the named disturbances."""

THIN = ("chairs", "plants", "lamps", "cables", "rods")
"""Kinds of scenes whose maps are attacked."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    case_study.add_arguments(parser, "true_maps", list(SPLITS))
    parser.add_argument(
        "--rods",
        action="store_true",
        help="measure errors at thin rods instead of rooms",
    )


def cases(split: str, first: int, count: int) -> list[Case]:
    """Returns cases of a split, in order.

    Args:
        split: Name of the split, or `named`.
        first: Number of the first case.
        count: Number of cases; of the named ones, at most all.
    """
    if split == NAMED_SPLIT:
        drawn = [Case(s, what) for s in NAMED_SEEDS for what in NAMED.values()]
        return drawn[first : first + count]
    start = SPLITS[split] + first
    return [draw_case(seed) for seed in range(start, start + count)]


def thin_cases(split: str, first: int, count: int) -> list[Case]:
    """Returns cases with thin and curved objects, whose maps are attacked.

    Those of the split `named` have no fault.

    Args:
        split: Name of the split, or `named`.
        first: Number of the first case.
        count: Number of cases.
    """
    numbers = range(first, first + count)
    kinds = [THIN[i % len(THIN)] for i in numbers]
    if split == NAMED_SPLIT:
        return [
            Case(1 + i, EXACT, kind=kind)
            for i, kind in zip(numbers, kinds, strict=True)
        ]
    start = SPLITS[split]
    return [
        draw_case(start + i, kind)
        for i, kind in zip(numbers, kinds, strict=True)
    ]


STUDY = CaseStudy(
    "true_maps",
    cases,
    run_trial,
    failed,
    restored,
    report.table,
    report.summary,
    attacked=thin_cases,
    attack=attack_case,
)


def run(arguments: argparse.Namespace) -> int:
    """Runs missing trials, or maps rods, and prints the results."""
    if not arguments.rods:
        return STUDY.run(arguments)
    STUDY.check(arguments)
    Console().print(rods.table(_rods(arguments.first, arguments.count)))
    return 0


def _rods(first: int, count: int) -> list[rods.RodResult]:
    """Measures some of the setups with rods."""
    results: list[rods.RodResult] = []
    setups = rods.SETUPS[first : first + count]
    with Progress(Console(stderr=True), "mapping rods") as progress:
        for done, setup in enumerate(setups):
            progress.report("mapping rods", done, len(setups))
            results += rods.measure(setup)
    return results


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("true_maps", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
