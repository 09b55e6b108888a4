"""One trial of the study: maps a disturbed capture, tests map and verdict."""

import dataclasses as dc
from time import perf_counter
from typing import Any

import numpy as np

from apps.studies.rigid_motion import CameraErrors, camera_errors
from apps.studies.true_maps.case import Case
from apps.studies.true_maps.judge import Excess, judge, laid_on_truth
from apps.studies.true_maps.sight import Sight
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.inspection import inspect_capture
from remosplat_drake.commands.capture_admission import after_alignment
from remosplat_drake.controller.ingredients import CollisionDamperConfig
from remosplat_drake.reconstruction.alignment.alignment import Alignment, align
from remosplat_drake.reconstruction.alignment.pose_errors import PoseErrors
from remosplat_drake.reconstruction.pipeline import reconstruct
from remosplat_drake.reconstruction.report.assessment import assess
from remosplat_drake.reconstruction.report.quality_report import (
    MAP_ERROR_MARGIN,
    QualityReport,
)
from remosplat_drake.reconstruction.report.validation import cross_validate
from remosplat_drake.reconstruction.surfels.point_cloud import (
    InitialisationConfig,
)
from remosplat_drake.reconstruction.workspace import Workspace
from remosplat_drake.splat.gaussian_splat import GaussianSplat

HELD_OUT = 8
"""Step between held-out views, as in `remosplat reconstruct`."""


@dc.dataclass(frozen=True)
class Result:
    """Result of a trial; all lengths in metres.

    Attributes:
        key: Name of the case.
        wrong: Description of the disturbance; empty for none.
        defects: Defects for which the inspection refuses the capture.
        warnings: Warnings of `remosplat reconstruct` if it is accepted.
        verdict: `remaining_error` of the quality report.
        map_error: `map_error` of the quality report.
        before: Errors of the given cameras.
        after: Errors of the refined ones.
        all: Over-estimates of distances near surfaces that two views saw, at
            least a pixel wide.
        thin: Over-estimates near surfaces less than a pixel wide.
        by_label: Those of `all`, by the label of the nearest surface.
        medium: Median uncertainty of the discs in the workspace.
        seconds: Time of the inspection, of the alignment, of the
            reconstruction, of the cross-validation and of the assessment
            [s].
        error: Error text; empty without an error.
    """

    key: str
    wrong: str = ""
    defects: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    verdict: float = np.nan
    map_error: float = np.nan
    before: CameraErrors | None = None
    after: CameraErrors | None = None
    all: Excess | None = None
    thin: Excess | None = None
    by_label: dict[str, Excess] = dc.field(default_factory=dict)
    medium: float = np.nan
    seconds: tuple[float, ...] = ()
    error: str = ""

    @property
    def is_runnable(self) -> bool:
        """Whether `remosplat run` accepts the map."""
        return not self.defects and is_runnable(self.verdict)

    @property
    def is_below(self) -> bool:
        """Whether the verdict is below the largest true error."""
        assert self.all is not None
        return self.all.worst > self.verdict


def is_runnable(verdict: float) -> bool:
    """Whether a robot may use a map at the usual stopping distance.

    It is the decision of `remosplat run` in simulation.

    Args:
        verdict: `remaining_error` of its quality report [m].
    """
    return verdict + MAP_ERROR_MARGIN <= CollisionDamperConfig().stopping


def failed(case: Case, error: str) -> Result:
    """Returns the result of a trial that failed."""
    return Result(case.key, str(case.disturbance), error=error)


def restored(fields: dict[str, Any]) -> Result:
    """Returns the result that a line of a results' file holds."""
    for name in ("before", "after"):
        fields[name] = CameraErrors(**fields[name])
    for name in ("all", "thin"):
        fields[name] = Excess(**fields[name])
    for label, excess in fields["by_label"].items():
        fields["by_label"][label] = Excess(**excess)
    for name in ("defects", "warnings", "seconds"):
        fields[name] = tuple(fields[name])
    return Result(**fields)


@dc.dataclass(frozen=True, eq=False)
class Mapped:
    """The output of `remosplat reconstruct` for a capture.

    Attributes:
        splat: The splat with its discs' uncertainty.
        alignment: The refined capture.
        report: The quality report.
        defects: Defects for which the inspection refuses the capture.
        seconds: Time of the inspection, of the alignment, of the
            reconstruction, of the cross-validation and of the assessment
            [s].
    """

    splat: GaussianSplat
    alignment: Alignment
    report: QualityReport
    defects: tuple[str, ...]
    seconds: tuple[float, ...]


def mapped(capture: Capture, focus_W: np.ndarray) -> Mapped:
    """Reconstructs a capture like `remosplat reconstruct --device cpu --focus`.

    A capture that the inspection refuses is mapped, too, as with `--accept`.

    Args:
        capture: The capture, z up and the floor at z = 0.
        focus_W: Centre of the robot's workspace, shape (3,) [m].

    Raises:
        RemoSplatError: The capture is invalid.
    """
    times = [perf_counter()]
    found = inspect_capture(capture)
    times.append(perf_counter())
    alignment = align(capture)
    errors = PoseErrors.of_draws(alignment.draws())
    times.append(perf_counter())
    held_out = np.arange(len(capture)) % HELD_OUT == 0
    initialisation = InitialisationConfig(focus=focus_W)
    workspace = Workspace.around(focus_W)
    made = reconstruct(
        alignment.capture,
        "cpu",
        initialisation=initialisation,
        bounded=True,
        errors=errors,
        held_out=held_out,
    )
    times.append(perf_counter())
    validations = cross_validate(
        alignment.capture, workspace, errors, initialisation
    )
    times.append(perf_counter())
    warnings = [f"{f.name}: {f.problem}" for f in found.findings]
    report = assess(
        made.splat,
        alignment.capture,
        np.flatnonzero(held_out).tolist(),
        workspace=workspace,
        method=made.method,
        warnings=after_alignment(warnings, alignment.capture, alignment.undone),
        validations=validations.of_oracles,
    ).report
    times.append(perf_counter())
    return Mapped(
        made.splat,
        alignment,
        report,
        tuple(finding.name for finding in found.defects),
        tuple(np.diff(times).tolist()),
    )


def run_trial(case: Case) -> Result:
    """Maps the capture of a case and compares map and verdict with the truth.

    Raises:
        Exception: Any error of the reconstruction.
    """
    taken = case.taken()
    sight = Sight(taken)
    made = mapped(taken.capture, taken.scene.focus_W)
    true_X_WC, X_MC = taken.cameras.X_WC, made.alignment.capture.X_WC
    splat_W = laid_on_truth(made.splat, X_MC, true_X_WC, sight)
    truth = judge(splat_W, sight, np.random.default_rng([case.seed, 9]))
    scale = case.disturbance.scale
    assert splat_W.uncertainty is not None
    own = splat_W.uncertainty[sight.in_workspace(splat_W.p_GK)]
    return Result(
        key=case.key,
        wrong=str(case.disturbance),
        defects=made.defects,
        warnings=tuple(w.split(":")[0] for w in made.report.warnings),
        verdict=made.report.remaining_error,
        map_error=made.report.map_error,
        before=camera_errors(taken.capture.X_WC, true_X_WC, scale),
        after=camera_errors(X_MC, true_X_WC, scale * made.alignment.scale),
        all=truth.all,
        thin=truth.thin,
        by_label=truth.by_label,
        medium=float(np.median(own)),
        seconds=made.seconds,
    )
