"""Makes the motions of `identify` and of the doctor, and counts contacts.

Robots start at random configurations that keep distances from the scene and
between links. A random axis makes the stroke that `remosplat identify` would
choose there, and a base makes the doctor's step, in simulation and with the
diagram of every run. Robots with a base start twice, once with the pose of a
simulated localisation. Every second pose has the largest delay that is
permitted before identification.
"""

import argparse
import sys
from collections.abc import Sequence

from rich.console import Console

from apps.studies.command_line import (
    add_count_flag,
    add_output_flag,
    check_least,
    study_main,
)
from apps.studies.kept_trials import run_missing
from apps.studies.strokes.report import table
from apps.studies.strokes.trial import failed, restored, run_trial, starts
from remosplat_drake.base.pool import Job
from remosplat_drake.commands.tables import print_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    add_count_flag(parser, "poses", 1000, "number of poses of each robot")
    add_count_flag(parser, "seed", 0, "seed of the poses")
    add_count_flag(parser, "jobs", 2, "number of parallel workers")
    add_output_flag(
        parser,
        "strokes",
        "folder of the results; existing results are not computed again",
    )


def run(arguments: argparse.Namespace) -> int:
    """Runs missing motions; returns 1 after a contact or a failure."""
    check_least("strokes", arguments, poses=1, seed=0, jobs=0)
    chosen = starts(arguments.poses, arguments.seed)
    results = run_missing(
        [Job(start, run_trial, failed) for start in chosen],
        arguments.output / "motions.jsonl",
        restored,
        arguments.jobs,
        "moving axes",
    )
    print_table(Console(), table(results))
    for result in results:
        if result.error or result.stopped or result.touched:
            print(f"{result.key}: {result.error or result.stopped}")
    return int(any(r.touched or r.wrong_places or r.error for r in results))


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("strokes", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
