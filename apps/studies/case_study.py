"""`CaseStudy`: a study that maps captures of many cases and evaluates them."""

import argparse
import dataclasses as dc
from collections.abc import Callable, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from apps.studies import attacks
from apps.studies.attacks import Aim, Attacks
from apps.studies.command_line import add_trial_flags, check_least
from apps.studies.kept_trials import run_missing
from remosplat_drake.base.pool import Job

NAMED = "named"
"""The split of named cases, with one fault each."""


@dc.dataclass(frozen=True)
class CaseStudy:
    """A study, run by the flags of `add_arguments`.

    Attributes:
        name: Name of the study's module in this folder.
        cases: Returns cases by split, number of the first, and count.
        run_trial: Makes the map of a case and evaluates it; the result has a
            `key` and an `error`.
        failed: Makes a result of a case and an error's text.
        restored: Makes a result of a line's fields.
        table: Lists results.
        summary: Summarises them, one line each.
        attacked: Returns the cases whose maps `--attacks` attacks.
        attack: Attacks the maps of a case.
    """

    name: str
    cases: Callable[[str, int, int], list[Any]]
    run_trial: Callable[[Any], Any]
    failed: Callable[[Any, str], Any]
    restored: Callable[[dict[str, Any]], Any]
    table: Callable[[Sequence[Any]], Table]
    summary: Callable[[Sequence[Any]], list[str]]
    attacked: Callable[[str, int, int], list[Any]]
    attack: Callable[[Aim], Attacks]

    def check(self, arguments: argparse.Namespace) -> None:
        """Checks the values of the flags of `add_arguments`.

        Raises:
            FieldError: One is out of its range.
        """
        check_least(self.name, arguments, count=1, first=0, jobs=0, attacks=0)

    def run(self, arguments: argparse.Namespace) -> int:
        """Runs missing trials and prints their results.

        Args:
            arguments: The values of the flags of `add_arguments`.

        Raises:
            FieldError: One is out of its range.
        """
        self.check(arguments)
        which = arguments.split, arguments.first, arguments.count
        if arguments.attacks:
            aims = [Aim(c, arguments.attacks) for c in self.attacked(*which)]
            jobs = [Job(aim, self.attack, attacks.failed) for aim in aims]
            lines = attacks.summary(
                self._results(jobs, arguments, "-attacks", attacks.restored)
            )
        else:
            jobs = [
                Job(c, self.run_trial, self.failed) for c in self.cases(*which)
            ]
            results = self._results(jobs, arguments, "", self.restored)
            Console().print(self.table(results))
            lines = self.summary(results)
        for line in lines:
            Console().print(line, highlight=False, soft_wrap=True)
        return 0

    def _results(
        self,
        jobs: list[Job],
        arguments: argparse.Namespace,
        suffix: str,
        restored: Callable[[dict[str, Any]], Any],
    ) -> list[Any]:
        """The results of all jobs; missing ones are computed."""
        path = arguments.output / f"{arguments.split}{suffix}.jsonl"
        return run_missing(jobs, path, restored, arguments.jobs)


def add_arguments(
    parser: argparse.ArgumentParser, name: str, splits: Sequence[str]
) -> None:
    """Declares the flags of a study of cases.

    Args:
        parser: Parser that receives the flags.
        name: Name of the study's module in this folder.
        splits: Names of the splits besides `NAMED`: first the one for the
            choice of constants, then the reported one.
    """
    parser.add_argument(
        "--split",
        choices=[NAMED, *splits],
        default=NAMED,
        help="split of the cases: one fault at a time (named), the choice of"
        " constants, or the reported results",
    )
    parser.add_argument(
        "--attacks",
        type=int,
        default=0,
        metavar="N",
        help="drive a robot to the N worst places of each map, in place of"
        " measuring its errors (0)",
    )
    add_trial_flags(parser, name, 8, "cases")
