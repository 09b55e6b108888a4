"""Makes the splats of scenes: renders views, fits discs, measures errors.

A splat and its record are files in the recipe's folder. The splat is written
last, so each splat in the folder has a record.
"""

import dataclasses as dc
from collections.abc import Callable, Iterable
from time import perf_counter

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.version import __version__
from remosplat_drake.benchmark.reaching_task import BenchmarkCase, known_solids
from remosplat_drake.benchmark.splat_recipe import SplatRecipe
from remosplat_drake.benchmark.splat_record import (
    SplatRecord,
    read_record,
    write_record,
)
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.synthetic import (
    render_capture,
    survey_poses,
)
from remosplat_drake.oracle.oracle_config import (
    DepthRasterization,
    OracleConfig,
    SphereToEllipsoid,
    make_field,
)
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.reconstruction.report.quality import (
    DistanceQuality,
    distance_quality,
)
from remosplat_drake.reconstruction.surfels.refinement import refine
from remosplat_drake.reconstruction.surfels.surfels import (
    Surfels,
    surfels_from_capture,
)
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.splat.codecs.ply import write_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat

Fit = Callable[[Capture, Surfels, SplatRecipe], GaussianSplat]
"""Function that makes a splat from a capture and its initial discs."""

ORACLES: dict[str, OracleConfig] = {
    "ellipsoid": SphereToEllipsoid(),
    "depth": DepthRasterization(),
}
"""Oracles with which a splat's distance errors are measured, by name."""

QUALITY_POINTS = 4000
"""Number of random points, in the space around start and target, at which
distances are measured. Errors are computed at those near the scene."""

MARGIN, FLOOR_MARGIN, HEIGHT = 0.6, 0.05, 1.4
"""Extent of the space around start and target in which distance errors are
measured [m]: horizontal margin, smallest height, largest height."""


@dc.dataclass(frozen=True)
class SplatOrder:
    """An order for a scene's splat; small enough to be sent to a worker.

    Attributes:
        case: The scene that needs a splat.
        recipe: Settings of the splat.
    """

    case: BenchmarkCase
    recipe: SplatRecipe


def failed_record(order: SplatOrder, error: str) -> SplatRecord:
    """Makes the record of an order that failed with an error."""
    return dc.replace(_head(order), error=error)


def make_splat(order: SplatOrder) -> SplatRecord:
    """Makes a scene's splat on the recipe's device and stores it.

    Raises:
        Exception: Any error of rendering, training or storing.
    """
    return make_splat_with(FITS[order.recipe.device], order)


def make_splat_with(fit: Fit, order: SplatOrder) -> SplatRecord:
    """Makes a scene's splat with a given fit and stores it.

    Args:
        fit: Function that fits the discs to the capture.
        order: The scene and the settings of its splat.

    Raises:
        Exception: Any error of rendering, fitting or storing.
    """
    recipe, truth = order.recipe, order.case.task().solids
    if truth is None or truth.X_WE_target is None:
        raise RemoSplatError(f"{order.case.name} cannot be rendered")
    started = perf_counter()
    capture = render_capture(
        truth,
        survey_poses(truth, recipe.views, recipe.seed),
        recipe.width,
        recipe.height,
    )
    surfels = surfels_from_capture(
        capture, recipe.count, focus=truth.X_WE_target.translation()
    )
    captured = perf_counter()
    splat = fit(capture, surfels, recipe)
    record = dc.replace(
        _head(order),
        count=len(splat),
        capture_seconds=captured - started,
        fit_seconds=perf_counter() - captured,
        quality=splat_quality(splat, truth),
    )
    path = recipe.splat_file(truth)
    write_record(path, record)
    write_ply(path, splat, with_normals=False)
    return record


def stored_records(
    cases: Iterable[BenchmarkCase], recipe: SplatRecipe
) -> list[SplatRecord]:
    """Returns the records of all cases that have a splat of a recipe."""
    scenes = (known_solids(case) for case in cases)
    files = (recipe.splat_file(scene) for scene in scenes if scene is not None)
    records = (read_record(path) for path in files if path.is_file())
    return [record for record in records if record is not None]


def splat_quality(
    splat_W: GaussianSplat, truth: PrimitiveScene
) -> dict[str, DistanceQuality]:
    """Measures a splat's distance errors in the space around start and target.

    Args:
        splat_W: The splat, expressed in W.
        truth: The scene's solids, with its task.

    Returns:
        Statistics of the errors, by the name of the oracle.
    """
    assert truth.X_WE_target is not None and truth.X_WB_start is not None
    way = np.array([truth.X_WE_target.translation()[:2], truth.X_WB_start[:2]])
    lower = np.array([*way.min(axis=0) - MARGIN, FLOOR_MARGIN])
    upper = np.array([*way.max(axis=0) + MARGIN, HEIGHT])
    field = SignedDistanceField(truth)
    return {
        name: distance_quality(
            make_field(config, splat_W, truth, name),
            field,
            lower,
            upper,
            QUALITY_POINTS,
        )
        for name, config in ORACLES.items()
    }


def _head(order: SplatOrder) -> SplatRecord:
    return SplatRecord(
        scene=order.case.name,
        family=order.case.family,
        origin=order.recipe.origin,
        recipe=dc.asdict(order.recipe),
        version=__version__,
    )


def _train(
    capture: Capture, surfels: Surfels, recipe: SplatRecipe
) -> GaussianSplat:
    # Imported here, since the packages of the extra `gpu` may be missing.
    from remosplat_drake.reconstruction.training import training

    config = training.TrainingConfig(steps=recipe.steps, seed=recipe.seed)
    start = refine(capture, surfels)
    return training.train_without_holes(capture, start, config).splat


def _refine(
    capture: Capture, surfels: Surfels, recipe: SplatRecipe
) -> GaussianSplat:
    del recipe  # It stops by itself and is deterministic.
    return refine(capture, surfels)


FITS: dict[str, Fit] = {"cuda": _train, "cpu": _refine}
"""Functions that fit splats, by the device that they run on."""
