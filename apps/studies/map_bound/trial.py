"""One trial of the study: reconstructs a disturbed capture, tests the map."""

import dataclasses as dc
from time import perf_counter
from typing import Any

import numpy as np

from apps.studies.map_bound.case import Case
from apps.studies.map_bound.judge import (
    Sight,
    random_queries,
    worst_queries,
)
from apps.studies.rigid_motion import CameraErrors, camera_errors
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.sensor_noise import sensor_noise
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.alignment.alignment import Alignment, align
from remosplat_drake.reconstruction.alignment.pose_errors import PoseErrors
from remosplat_drake.reconstruction.pipeline import reconstruct
from remosplat_drake.splat.gaussian_splat import GaussianSplat

QUERIES = 20_000
"""A map is judged at the usable ones of this many random points."""


@dc.dataclass(frozen=True)
class Result:
    """Result of a trial; all lengths in metres.

    Attributes:
        key: Name of the case.
        before: Errors of the disturbed capture.
        after: Errors of the refined one.
        queries: Number of points whose nearest surface was seen well.
        exceeded: Number of these at which the distance, after subtraction of
            the discs' uncertainty, exceeds the true one.
        worst: Largest excess of such a distance over the true one.
        over: Largest over-estimate at these points, without any subtraction.
        bound: Largest uncertainty of a disc in the workspace.
        looseness: Median and 90th percentile of the true distance minus the
            robot's.
        medium: Median uncertainty of the discs.
        seconds: Time of the reconstruction, and how much of it was alignment
            [s].
        error: Error text; empty without an error.
    """

    key: str
    before: CameraErrors | None = None
    after: CameraErrors | None = None
    queries: int = 0
    exceeded: int = 0
    worst: float = np.nan
    over: float = np.nan
    bound: float = np.nan
    looseness: tuple[float, float] = (np.nan, np.nan)
    medium: float = np.nan
    seconds: tuple[float, float] = (np.nan, np.nan)
    error: str = ""


def failed(case: Case, error: str) -> Result:
    """Returns the result of a trial that failed."""
    return Result(case.key, error=error)


def restored(fields: dict[str, Any]) -> Result:
    """Returns the result that a line of a results' file holds."""
    for name in ("before", "after"):
        fields[name] = CameraErrors(**fields[name])
    return Result(**fields)


@dc.dataclass(frozen=True, eq=False)
class Mapped:
    """The map of a disturbed capture, and the truth.

    Attributes:
        splat: The splat with its discs' uncertainty, in W.
        alignment: The refined capture.
        capture: The disturbed capture.
        sight: The truth.
        seconds: Time of the reconstruction, and how much of it was alignment
            [s].
    """

    splat: GaussianSplat
    alignment: Alignment
    capture: Capture
    sight: Sight
    seconds: tuple[float, float]


def make_map(case: Case) -> Mapped:
    """Reconstructs the capture of a case, without the truth.

    Raises:
        Exception: Any error of the reconstruction.
    """
    scene, perfect, capture = case.captures()
    sensor = sensor_noise(case.disturbance.sensor)
    sight = Sight(scene, perfect, capture.depth, sensor)
    start = perf_counter()
    alignment = align(capture)
    aligned = perf_counter() - start
    errors = PoseErrors.of_draws(alignment.draws())
    made = reconstruct(alignment.capture, "cpu", bounded=True, errors=errors)
    seconds = perf_counter() - start, aligned
    return Mapped(made.splat, alignment, capture, sight, seconds)


def run_trial(case: Case) -> Result:
    """Reconstructs the capture of a case and compares the splat with the truth.

    Raises:
        Exception: Any error of the reconstruction.
    """
    mapped = make_map(case)
    sight, alignment = mapped.sight, mapped.alignment
    rng = np.random.default_rng([case.seed, 2])
    raw = SphereToEllipsoidField(mapped.splat.with_uncertainty(None))
    careful = SphereToEllipsoidField(mapped.splat)
    queries = random_queries(sight, QUERIES, rng)
    queries = queries.joined(worst_queries(raw, sight, rng)).well_seen()
    over, excess = queries.over_estimates(raw), queries.over_estimates(careful)
    true_X_WC, scale = sight.perfect.X_WC, case.disturbance.scale
    near = np.abs(mapped.splat.p_GK - sight.focus_W).max(axis=1) < 1
    assert mapped.splat.uncertainty is not None
    own = mapped.splat.uncertainty[near]
    return Result(
        key=case.key,
        before=camera_errors(mapped.capture.X_WC, true_X_WC, scale),
        after=camera_errors(
            alignment.capture.X_WC, true_X_WC, scale * alignment.scale
        ),
        queries=len(over),
        exceeded=int((excess > 0).sum()),
        worst=float(excess.max(initial=-np.inf)),
        over=float(over.max(initial=0.0)),
        bound=float(own.max(initial=0.0)),
        looseness=tuple(np.percentile(-excess, [50, 90]).tolist()),
        medium=float(np.median(own)),
        seconds=mapped.seconds,
    )
