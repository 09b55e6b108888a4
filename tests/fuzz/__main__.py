"""`python -m tests.fuzz --hours 2 --seed 7 --format ply`: the long campaign."""

import argparse
import sys
from pathlib import Path

# The other tests' writers are found as pytest finds them.
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from rich.console import Console
from rich.live import Live
from rich.table import Table

from fuzz.campaign import FAILURES, Outcome, counts, run
from fuzz.formats import FORMATS, interleaved

KINDS = ("read", "refused", "missing", *FAILURES)


def main() -> int:
    """Runs until time is up; 1 if a file has done what none may."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz")
    parser.add_argument(
        "--hours", type=float, default=1.0, help="default: %(default)s"
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=1,
        help="the first; the last line says where to go on",
    )
    parser.add_argument(
        "--format",
        action="append",
        choices=sorted(FORMATS),
        help="only this one; may be repeated",
    )
    parser.add_argument(
        "--keep",
        type=Path,
        default=Path("fuzz-failures"),
        metavar="DIR",
        help="where failing files go (default: %(default)s)",
    )
    arguments = parser.parse_args()
    names = arguments.format or list(FORMATS)
    console = Console()
    outcomes: list[Outcome] = []
    with Live(console=console, refresh_per_second=2) as live:

        def tell(outcome: Outcome) -> None:
            outcomes.append(outcome)
            if outcome.failed:
                console.print(
                    f"{outcome.format} {outcome.seed}: {outcome.kind}:"
                    f" {outcome.text}",
                    markup=False,
                )
            if len(outcomes) % 100 == 0:
                live.update(_table(outcomes))

        run(
            interleaved(names, arguments.seed),
            keep=arguments.keep,
            tell=tell,
            seconds=3600 * arguments.hours,
        )
        live.update(_table(outcomes))
    console.print(f"go on with --seed {outcomes[-1].seed}")
    return int(any(outcome.failed for outcome in outcomes))


def _table(outcomes: list[Outcome]) -> Table:
    table = Table("format", *KINDS)
    for name, kinds in counts(outcomes).items():
        table.add_row(name, *(str(kinds[kind] or "") for kind in KINDS))
    return table


if __name__ == "__main__":
    sys.exit(main())
