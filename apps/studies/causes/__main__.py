"""Tests whether stated causes are true, and whether offered actions work.

Each seed gives a run in which the robot cannot reach its target. There are ten
kinds of causes, in turn: the scene, unseen space, the robot itself, a joint
limit, a mover, the base, the supervisor, the localisation, no configuration, no
path. The study compares the first stated cause with the truth. Then it executes
the first action that is offered: another target, a release, or waiting. Seeds
below 10,000 are for development.
"""

import argparse
import sys
from collections.abc import Sequence

import numpy as np

from apps.studies.causes.situations import KINDS
from apps.studies.causes.trial import (
    Outcome,
    Trial,
    failed,
    restored,
    run_trial,
)
from apps.studies.command_line import (
    add_trial_flags,
    check_least,
    study_main,
)
from apps.studies.kept_trials import run_missing
from remosplat_drake.base.pool import Job
from remosplat_drake.base.table import Table

TRIALS = "trials.jsonl"
"""Name of the result file in the output folder."""


def table_of(outcomes: Sequence[Outcome]) -> Table:
    """Makes a table of causes and actions by kind.

    Args:
        outcomes: The outcomes.
    """
    rows = [
        _row(kind, some)
        for kind in KINDS
        if (some := [each for each in outcomes if each.kind == kind])
    ]
    rows.append(_row("all", list(outcomes)))
    header = ("holder", "runs", "right cause", "slowest [s]", "action works")
    return Table("", header, tuple(rows))


def _row(kind: str, some: list[Outcome]) -> tuple[str, ...]:
    held = [each for each in some if not each.is_free]
    right = [each for each in held if each.is_right]
    helped = [each for each in held if each.actions]
    delay = max((each.delay for each in right), default=np.nan)
    return (
        kind,
        f"{len(held)}",
        f"{len(right)}",
        f"{delay:.1f}",
        f"{sum(each.works for each in helped)} of {len(helped)}",
    )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the flags."""
    add_trial_flags(parser, "causes", 100, "runs")


def run(arguments: argparse.Namespace) -> int:
    """Runs the trials that have no line yet, and prints the table."""
    check_least("causes", arguments, first=0, count=1, jobs=0)
    seeds = range(arguments.first, arguments.first + arguments.count)
    outcomes = run_missing(
        [Job(Trial(seed), run_trial, failed) for seed in seeds],
        arguments.output / TRIALS,
        restored,
        arguments.jobs,
        "holding robots",
    )
    print(table_of(outcomes).to_markdown(), end="")
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line."""
    return study_main("causes", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
