"""The table of a study's motions, one row for each robot and kind."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from apps.studies.strokes.trial import Result
from remosplat_drake.base.table import Table


def table(results: Sequence[Result]) -> Table:
    """Makes the table.

    Args:
        results: The results of all motions.
    """
    groups = defaultdict(list)
    for result in results:
        groups[result.group].append(result)
    return Table(
        "",
        (
            "robot and motion",
            "poses",
            "no room",
            "failed",
            "slowed",
            "stopped",
            "contacts",
            "wrong places",
            "error / bound",
            "links [mm]",
            "scene [mm]",
        ),
        tuple((name, *_cells(group)) for name, group in groups.items()),
        texts=1,
    )


def _cells(group: Sequence[Result]) -> list[str]:
    counts = [
        len(group),
        sum(bool(r.no_room) for r in group),
        sum(bool(r.error) for r in group),
        sum(r.was_slowed for r in group),
        sum(bool(r.stopped) for r in group),
        sum(r.touched for r in group),
        sum(r.wrong_places for r in group),
    ]
    share = max(r.error_share for r in group)
    own = min((r.own for r in group if r.own is not None), default=np.nan)
    scene = min((r.scene for r in group if r.scene is not None), default=np.nan)
    return [
        *map(str, counts),
        f"{share:.2f}" if share else "",
        f"{1e3 * own:.1f}",
        f"{1e3 * scene:.1f}",
    ]
