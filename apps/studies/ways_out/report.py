"""The report of the trials, robot by robot."""

from collections.abc import Iterator, Sequence

import numpy as np
from rich.table import Table

from apps.studies.ways_out.on_the_wire import WireResult
from apps.studies.ways_out.trial import Result


def table(results: Sequence[Result]) -> Table:
    """Makes the table of all robots.

    Args:
        results: The results of all trials.
    """
    made = Table("robot, near", "starts", "out", "of those with a way")
    made.add_column("time, median and worst [s]")
    made.add_column("largest decrease of a distance, at ticks and between [mm]")
    made.add_column("largest decrease for joints [mrad]")
    made.add_column("stopped")
    for group in dict.fromkeys(r.group for r in results):
        of = [r for r in results if r.group == group and not r.error]
        if not of:
            continue
        times = [r.out_after for r in of if r.out_after is not None]
        ways = len(times) + sum(r.has_way is True for r in of)
        ticks = 1e3 * max(r.nearer_at_ticks for r in of)
        between = 1e3 * max(r.nearer_between for r in of)
        spread = f"{np.median(times):.2f}, {max(times):.2f}" if times else ""
        made.add_row(
            group,
            str(len(of)),
            str(len(times)),
            f"{100 * len(times) / ways:.1f} %" if ways else "",
            spread,
            f"{ticks:.4f}, {between:.4f}",
            f"{1e3 * max(r.joints_nearer for r in of):.4f}",
            str(sum(bool(r.stopped) for r in of)),
        )
    return made


def wire_table(results: Sequence[WireResult]) -> Table:
    """Makes the table of all starts on the wire.

    Args:
        results: The results of all starts.
    """
    made = Table("start", "inside [mm]", "out after [s]", "left [mm]")
    made.add_column("largest decrease of a distance [mm]")
    for r in results:
        if r.error:
            continue
        made.add_row(
            r.key,
            f"{1e3 * r.depth:.1f}",
            "" if r.out_after is None else f"{r.out_after:.2f}",
            f"{1e3 * r.left:.2f}",
            f"{1e3 * r.nearer:.2f}",
        )
    return made


def summary(results: Sequence[Result]) -> Iterator[str]:
    """Names the starts that did not get out, and those without a result.

    Args:
        results: The results of all trials.
    """
    for r in results:
        if r.error:
            yield f"{r.key}: {r.error.splitlines()[-1]}"
        elif r.out_after is None:
            way = "a way is known" if r.has_way else "no way is known"
            yield (
                f"{r.key}: {1e3 * r.depth:.1f} mm inside, {1e3 * r.left:.1f} mm"
                f" in the end; {way}" + (r.stopped and f"; {r.stopped}")
            )
