"""`assess`: measures the errors of a splat against its capture."""

import dataclasses as dc
from collections.abc import Callable, Sequence

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.point_distance import PointDistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.coverage import make_coverage
from remosplat_drake.reconstruction.measured_space import (
    free_points,
    measured_points,
    scatter,
)
from remosplat_drake.reconstruction.report.floaters import (
    Floaters,
    find_floaters,
)
from remosplat_drake.reconstruction.report.pictures import (
    Picture,
    draw_pictures,
    score_pictures,
)
from remosplat_drake.reconstruction.report.quality import summarize
from remosplat_drake.reconstruction.report.quality_report import (
    CAPTURE,
    DEPTH_VIEWS,
    ELLIPSOIDS,
    HELD_OUT,
    TRUTH,
    CoverageSummary,
    DistanceErrors,
    FloaterSummary,
    QualityReport,
    judge,
    reference_of,
    remaining_of,
)
from remosplat_drake.reconstruction.report.validation import (
    NEAREST,
    Validation,
)
from remosplat_drake.reconstruction.workspace import Workspace
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.coverage import FREE, SURFACE, UNSEEN, Coverage
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

FARTHEST = 0.5
"""Fields are compared at distances up to this, the controller's range [m]."""

_SINGLE = 2
"""This many of the largest errors are ignored, since flying pixels may have
caused them.
"""

_Errors = dict[str, dict[str, np.ndarray]]
"""Measured minus expected distances [m], keyed by reference and then by oracle.
"""

_NOTHING = 1.0  # Distance of an oracle without a surface in range [m].
_LISTED_FLOATERS = 100


@dc.dataclass(frozen=True, eq=False)
class Assessment:
    """A quality report and the data that its pictures are drawn from.

    Attributes:
        report: The numbers of the assessment.
        pictures: The views that were compared.
        errors: Measured distances minus those of the best reference, keyed by
            oracle, each of shape (n,) [m].
        coverage: Coverage of the workspace.
        floaters: Floaters in the workspace.
    """

    report: QualityReport
    pictures: tuple[Picture, ...]
    errors: dict[str, np.ndarray]
    coverage: Coverage
    floaters: Floaters


def assess(
    splat_W: GaussianSplat,
    capture: Capture,
    compared: Sequence[int],
    *,
    truth: PrimitiveScene | None = None,
    workspace: Workspace | None = None,
    method: str = "unknown",
    held_out: bool = True,
    count: int = 5000,
    seed: int = 0,
    warnings: Sequence[str] = (),
    validations: Sequence[Validation] = (),
    progress: Callable[[str], None] = lambda step: None,
) -> Assessment:
    """Measures a splat's images, distances, floaters and coverage.

    Args:
        splat_W: The splat, in the capture's world frame.
        capture: All views, including those used for training.
        compared: Indices of the views whose images are compared with
            renderings.
        truth: The true geometry; None if unknown.
        workspace: Box in which distances are compared; None: a box around most
            of the captured surfaces.
        method: Description of how the splat was made.
        held_out: Whether the compared views were not used for training.
        count: Largest number of points at which distances are compared.
        seed: Seed of the random points.
        warnings: Sentences about faults of the capture.
        validations: Errors at held-out views, see `cross_validate`; they
            determine the verdict unless the truth is known.
        progress: Called with the name of the next step.

    Raises:
        RemoSplatError: The capture shows no surface or no free space in the
            workspace, or `compared` is empty.
    """
    if not len(compared):
        raise RemoSplatError("the capture has no view to compare")
    workspace = workspace or Workspace.of_capture(capture)
    box = workspace.lower, workspace.upper
    progress("collecting the measured surfaces")
    known = _without(capture, compared) if held_out else capture
    surface_W = measured_points(known, box[0] - FARTHEST, box[1] + FARTHEST)
    references = _references(surface_W, truth)
    progress("comparing distances")
    distances, errors = _compare_distances(
        splat_W, known, references, workspace, count, seed
    )
    validations = [each for each in validations if each.is_conclusive]
    distances += [_held_out_row(each) for each in validations]
    errors[HELD_OUT] = {each.oracle: each.over for each in validations}
    progress("looking for floaters and unseen space")
    floaters = find_floaters(splat_W, known, references[CAPTURE], *box)
    coverage = make_coverage(known, surface_W, *box)
    progress("rendering the compared views")
    pictures = draw_pictures(splat_W, capture, compared)
    report = QualityReport(
        method=method,
        splats=len(splat_W),
        views=len(capture),
        scatter=scatter(surface_W),
        distances=distances,
        images=score_pictures(pictures, capture, held_out),
        floaters=_summarize_floaters(floaters),
        coverage=_summarize_coverage(coverage),
        warnings=list(warnings),
    )
    best = errors[reference_of(report)]
    report = _judged(report, _own_error(splat_W, workspace))
    return Assessment(report, pictures, best, coverage, floaters)


def _judged(report: QualityReport, own: float) -> QualityReport:
    """Returns the report with the values and the verdict from its data."""
    best = reference_of(report)
    over = max(d.over for d in report.distances if d.reference == best)
    report.uncertainty = own
    report.map_error = max(over, own)
    report.remaining_error = remaining_of(report, ELLIPSOIDS)
    report.trust = judge(report)
    return report


def _held_out_row(validation: Validation) -> DistanceErrors:
    """Errors at surfaces of held-out views."""
    summary = summarize(validation.over)
    return DistanceErrors(
        validation.oracle,
        HELD_OUT,
        **{**dc.asdict(summary), "over": validation.largest_over},
        remaining=validation.verdict,
        covered=validation.covered,
    )


def _own_error(splat_W: GaussianSplat, workspace: Workspace) -> float:
    """Largest uncertainty of a disc in the workspace [m]; 0 without any."""
    if splat_W.uncertainty is None:
        return 0.0
    inside = splat_W.inside(workspace.lower, workspace.upper)
    return float(splat_W.uncertainty[inside].max(initial=0.0))


def _references(
    surface_W: np.ndarray, truth: PrimitiveScene | None
) -> dict[str, DistanceField]:
    """References that distances are compared with, keyed by name."""
    if not len(surface_W):
        raise RemoSplatError("the capture shows no surface in the workspace")
    fields: dict[str, DistanceField] = {CAPTURE: PointDistanceField(surface_W)}
    if truth is not None:
        fields[TRUTH] = SignedDistanceField(truth)
    return fields


def _without(capture: Capture, held_out: Sequence[int]) -> Capture:
    """Returns the capture of the views from which the splat was made."""
    used = np.ones(len(capture), bool)
    used[list(held_out)] = False
    return capture.select(used)


def _compare_distances(
    splat_W: GaussianSplat,
    capture: Capture,
    references: dict[str, DistanceField],
    workspace: Workspace,
    count: int,
    seed: int,
) -> tuple[list[DistanceErrors], _Errors]:
    """Compares both oracles with all references, in space that cameras saw.

    An error does not depend on a sphere's radius, so points suffice.
    """
    p_W = free_points(
        capture, count, workspace.lower, workspace.upper, FARTHEST, seed
    )
    expected = {}
    near = np.ones(len(p_W), bool)
    for name, field in references.items():
        expected[name] = field.clearances(Spheres.at(p_W)).per_sphere(len(p_W))
        near &= (expected[name] > NEAREST) & (expected[name] < FARTHEST)
    if not near.any():
        raise RemoSplatError("the capture shows no free space near a surface")
    spheres = Spheres.at(p_W[near])
    expected = {name: distance[near] for name, distance in expected.items()}
    # Errors of the surfaces, before their uncertainty is subtracted.
    errors = _errors(splat_W.with_uncertainty(None), spheres, expected)
    careful = errors
    if splat_W.uncertainty is not None:
        careful = _errors(splat_W, spheres, expected)
    rows = [
        DistanceErrors(
            oracle,
            reference,
            **dc.asdict(summarize(error)),
            remaining=_rest(reference, careful[reference][oracle]),
            covered=float((careful[reference][oracle] <= 0).mean()),
        )
        for reference, by_oracle in errors.items()
        for oracle, error in by_oracle.items()
    ]
    return rows, errors


def _rest(reference: str, careful: np.ndarray) -> float:
    """Returns over-estimates beyond the uncertainty, 0 for none [m].

    For a capture's own depth, single points are ignored.
    """
    largest = np.sort(careful)[::-1]
    single = 0 if reference == TRUTH else min(_SINGLE, len(largest) - 1)
    return max(float(largest[single]), 0.0)


def _errors(
    splat_W: GaussianSplat, spheres: Spheres, expected: dict[str, np.ndarray]
) -> dict[str, dict[str, np.ndarray]]:
    """Measured minus expected distances, keyed by reference and oracle [m]."""
    oracles = {
        ELLIPSOIDS: SphereToEllipsoidField(splat_W),
        DEPTH_VIEWS: DepthRasterizationField(splat_W, nearest_only=True),
    }
    errors: dict[str, dict[str, np.ndarray]] = {r: {} for r in expected}
    for name, oracle in oracles.items():
        measured = oracle.clearances(spheres).per_sphere(len(spheres))
        measured = np.minimum(measured, _NOTHING)
        for reference, distance in expected.items():
            errors[reference][name] = measured - distance
    return errors


def _summarize_floaters(floaters: Floaters) -> FloaterSummary:
    return FloaterSummary(
        count=len(floaters),
        worst=float(floaters.height.max(initial=0.0)),
        p_WK=floaters.p_WK[:_LISTED_FLOATERS].round(4).tolist(),
    )


def _summarize_coverage(coverage: Coverage) -> CoverageSummary:
    return CoverageSummary(
        lower=coverage.lower.tolist(),
        upper=coverage.upper.tolist(),
        free=coverage.fraction(FREE),
        surface=coverage.fraction(SURFACE),
        unseen=coverage.fraction(UNSEEN),
    )
