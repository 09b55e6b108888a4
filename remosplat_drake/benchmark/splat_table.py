"""Makes the table of the quality of a benchmark's splats."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from remosplat_drake.base.table import Table
from remosplat_drake.benchmark.cells import format_median
from remosplat_drake.benchmark.reaching_task import TRAINED
from remosplat_drake.benchmark.splat_recipe import SplatRecipe
from remosplat_drake.benchmark.splat_record import SplatRecord
from remosplat_drake.reconstruction.report.quality import DistanceQuality


def splat_table(records: Sequence[SplatRecord]) -> Table | None:
    """Makes the table of counts, times and distance errors by family.

    Returns:
        The table; None without records.
    """
    groups = defaultdict(list)
    for record in records:
        settings = tuple(sorted(record.recipe.items()))
        groups[record.family, record.origin, settings].append(record)
    oracles = sorted({oracle for r in records for oracle in r.quality})
    errors = [
        f"{oracle}: {column} [mm]"
        for oracle in oracles
        for column in ("median", "99 %", "over", "under")
    ]
    rows = tuple(
        (family, origin, _recipe(group[0]), *_row(group, oracles))
        for (family, origin, _), group in sorted(
            groups.items(), key=lambda item: item[0]
        )
    )
    if not rows:
        return None
    return Table(
        "splats made for the scenes",
        (
            "family",
            "splat",
            "recipe",
            "made",
            "failed",
            "discs",
            "capture [s]",
            "fit [s]",
            *errors,
        ),
        rows,
        "Seconds and numbers of discs are medians over the scenes; several "
        "splats were made at the same time. Errors are errors of distances "
        "from free points around start and target, 3 to 50 cm from the scene. "
        "Each scene has a median error and a 99th percentile. The columns "
        "contain the medians of these two values over the scenes, and the "
        "largest over- and underestimate in all scenes.",
        texts=3,
    )


def _recipe(record: SplatRecord) -> str:
    """Describes the most important settings of a recipe."""
    recipe = SplatRecipe(**record.recipe)
    steps = f", {recipe.steps} steps" if record.origin == TRAINED else ""
    size = f"{recipe.width} x {recipe.height}"
    return f"{recipe.views} views {size}{steps}"


def _row(
    records: Sequence[SplatRecord], oracles: Sequence[str]
) -> tuple[str, ...]:
    made = [record for record in records if not record.error]

    def median(field: str, decimals: int) -> str:
        values = np.array([getattr(record, field) for record in made])
        return format_median(values, decimals)

    cells = []
    for oracle in oracles:
        cells += _errors([r.quality[oracle] for r in made])
    return (
        str(len(made)),
        str(len(records) - len(made)),
        median("count", 0),
        median("capture_seconds", 1),
        median("fit_seconds", 1),
        *cells,
    )


def _errors(qualities: Sequence[DistanceQuality]) -> list[str]:
    if not qualities:
        return ["–"] * 4

    def millimetres(field: str) -> np.ndarray:
        return 1e3 * np.array([getattr(q, field) for q in qualities])

    return [
        format_median(millimetres("median"), 1),
        format_median(millimetres("percentile_99"), 1),
        f"{millimetres('over').max():.1f}",
        f"{millimetres('under').max():.1f}",
    ]
