"""Measures how far a splat can be trusted, against the capture it is from."""

import dataclasses as dc
from collections.abc import Callable, Sequence

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.errors import RemoSplatError
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.distance_field import DistanceField
from remosplat_drake.oracle.point_distance import PointDistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.coverage import (
    FREE,
    SURFACE,
    UNSEEN,
    Coverage,
    make_coverage,
)
from remosplat_drake.reconstruction.floaters import Floaters, find_floaters
from remosplat_drake.reconstruction.image_quality import (
    psnr,
    structural_similarity,
)
from remosplat_drake.reconstruction.measured_space import (
    free_points,
    measured_points,
    scatter,
)
from remosplat_drake.reconstruction.quality import summarize
from remosplat_drake.reconstruction.quality_report import (
    CAPTURE,
    TRUTH,
    CoverageSummary,
    DistanceErrors,
    FloaterSummary,
    ImageScores,
    QualityReport,
    judge,
    reference_of,
)
from remosplat_drake.reconstruction.splat_image import SplatImage, SplatRenderer
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.splat.gaussian_splat import GaussianSplat

NEAREST, FARTHEST = 0.03, 0.5
"""Distances at which fields are compared: no robot sphere has its centre
nearer to a surface, and the controller looks no farther [m]."""

_NOTHING = 1.0  # An oracle that sees nothing has measured this [m].
_BEST_PSNR = 99.0  # Of equal images; JSON knows no infinity [dB].
_LISTED_FLOATERS = 100


@dc.dataclass(frozen=True)
class Workspace:
    """A box in W that the robot moves in; distances are compared inside.

    Attributes:
        lower: Lower corner, shape (3,) [m].
        upper: Upper corner, shape (3,) [m].
    """

    lower: np.ndarray
    upper: np.ndarray

    @staticmethod
    def around(focus: np.ndarray, reach: float = 1.0) -> "Workspace":
        """A cube around a point, the target for example.

        Of a point above the floor, z = 0, only what is above the floor.
        """
        focus = np.asarray(focus, float)
        lower = focus - reach
        if focus[2] > 0:
            lower[2] = max(lower[2], 0)
        return Workspace(lower, focus + reach)

    @staticmethod
    def of_capture(capture: Capture) -> "Workspace":
        """What holds most of what was captured: 2 % are beyond each side."""
        points = [
            capture.points_W(i)[::8, ::8].reshape(-1, 3)
            for i in range(len(capture))
        ]
        p_W = np.concatenate(points)
        p_W = p_W[np.isfinite(p_W).all(axis=1)]
        if not len(p_W):
            raise RemoSplatError("the capture has no depth to compare with")
        return Workspace(*np.percentile(p_W, [2, 98], axis=0))


@dc.dataclass(frozen=True, eq=False)
class Picture:
    """One captured view and what the splat shows from there.

    Attributes:
        view: Index in the capture.
        rendered: The splat's image.
        rgb: The captured colours, (h, w, 3), uint8.
        depth: The captured depth, (h, w) [m]; 0 where unknown.
    """

    view: int
    rendered: SplatImage
    rgb: np.ndarray
    depth: np.ndarray

    @property
    def depth_error(self) -> np.ndarray:
        """Rendered minus captured, (h, w) [m]; NaN where either is unknown."""
        known = (self.depth > 0) & (self.rendered.depth > 0)
        return np.where(known, self.rendered.depth - self.depth, np.nan)


@dc.dataclass(frozen=True, eq=False)
class Assessment:
    """A report and what its pictures are drawn from.

    Attributes:
        report: The numbers.
        pictures: The views that were compared.
        errors: Measured minus true distances by oracle, against the best
            reference, each (n,) [m].
        coverage: Of the workspace.
        floaters: Those in the workspace.
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
    progress: Callable[[str], None] = lambda step: None,
) -> Assessment:
    """Measures a splat's images, distances, floaters and coverage.

    Args:
        splat_W: The splat, in the capture's world frame.
        capture: All views, those that training used too.
        compared: Indices of the views whose images are compared.
        truth: The true geometry, where it is known.
        workspace: Where distances matter; None: where most was captured.
        method: How the splat was made, in words.
        held_out: Whether training did without the compared views.
        count: Points at which distances are compared, at most.
        seed: Of the random points.
        progress: Told what is done next.

    Raises:
        RemoSplatError: The capture shows no surface or no free space in the
            workspace, or no view is to be compared.
    """
    if not len(compared):
        raise RemoSplatError("no view of the capture is to be compared")
    workspace = workspace or Workspace.of_capture(capture)
    progress("collecting the measured surfaces")
    surface_W = measured_points(
        capture, workspace.lower - FARTHEST, workspace.upper + FARTHEST
    )
    if not len(surface_W):
        raise RemoSplatError("the capture shows no surface in the workspace")
    references: dict[str, DistanceField] = {
        CAPTURE: PointDistanceField(surface_W)
    }
    if truth is not None:
        references[TRUTH] = SignedDistanceField(truth)
    progress("comparing distances")
    distances, errors = _compare_distances(
        splat_W, capture, references, workspace, count, seed
    )
    progress("looking for floaters and unseen space")
    floaters = find_floaters(
        splat_W.cropped(workspace.lower, workspace.upper),
        capture,
        references[CAPTURE],
    )
    coverage = make_coverage(
        capture, surface_W, workspace.lower, workspace.upper
    )
    progress("rendering the compared views")
    pictures = _draw(splat_W, capture, compared)
    report = QualityReport(
        method=method,
        splats=len(splat_W),
        views=len(capture),
        scatter=scatter(surface_W),
        distances=distances,
        images=_score(pictures, capture, held_out),
        floaters=FloaterSummary(
            count=len(floaters),
            worst=float(floaters.height.max(initial=0.0)),
            p_WK=floaters.p_WK[:_LISTED_FLOATERS].round(4).tolist(),
        ),
        coverage=CoverageSummary(
            lower=coverage.lower.tolist(),
            upper=coverage.upper.tolist(),
            free=coverage.fraction(FREE),
            surface=coverage.fraction(SURFACE),
            unseen=coverage.fraction(UNSEEN),
        ),
    )
    best = reference_of(report)
    report.map_error = max(d.over for d in distances if d.reference == best)
    report.trust = judge(report)
    return Assessment(report, pictures, errors[best], coverage, floaters)


def _compare_distances(
    splat_W: GaussianSplat,
    capture: Capture,
    references: dict[str, DistanceField],
    workspace: Workspace,
    count: int,
    seed: int,
) -> tuple[list[DistanceErrors], dict[str, dict[str, np.ndarray]]]:
    """Both oracles against all references, in space that cameras saw.

    The radius of a sphere adds nothing to an error, so points will do.
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
    oracles = {
        "sphere-to-ellipsoid": SphereToEllipsoidField(splat_W),
        "depth rasterisation": DepthRasterizationField(
            splat_W, nearest_only=True
        ),
    }
    errors: dict[str, dict[str, np.ndarray]] = {r: {} for r in references}
    for name, oracle in oracles.items():
        measured = oracle.clearances(spheres).per_sphere(len(spheres))
        measured = np.minimum(measured, _NOTHING)
        for reference in references:
            error = measured - expected[reference][near]
            errors[reference][name] = error
    rows = [
        DistanceErrors(oracle, reference, **dc.asdict(summarize(error)))
        for reference, by_oracle in errors.items()
        for oracle, error in by_oracle.items()
    ]
    return rows, errors


def _draw(
    splat_W: GaussianSplat, capture: Capture, compared: Sequence[int]
) -> tuple[Picture, ...]:
    renderer = SplatRenderer(splat_W)
    return tuple(
        Picture(
            int(i),
            renderer.render(capture.K[i], capture.X_WC[i], capture.size),
            capture.rgb[i],
            capture.depth[i],
        )
        for i in compared
    )


def _score(
    pictures: tuple[Picture, ...], capture: Capture, held_out: bool
) -> ImageScores:
    ratios, similarities, depth_errors = [], [], []
    for picture in pictures:
        hidden = (
            None if capture.hidden is None else capture.hidden[picture.view]
        )
        rendered = np.clip(picture.rendered.color, 0, 1)
        captured = picture.rgb / 255.0
        ratio = psnr(rendered, captured, hidden)
        ratios.append(min(ratio, _BEST_PSNR))
        similarities.append(structural_similarity(rendered, captured, hidden))
        error = picture.depth_error
        depth_errors.append(np.abs(error[np.isfinite(error)]))
    depth_error = np.concatenate(depth_errors)
    median, percentile = (
        np.percentile(depth_error, [50, 99]) if len(depth_error) else (0, 0)
    )
    return ImageScores(
        views=len(pictures),
        held_out=held_out,
        psnr=float(np.nanmean(ratios)),
        ssim=float(np.nanmean(similarities)),
        depth_median=float(median),
        depth_percentile_99=float(percentile),
    )
