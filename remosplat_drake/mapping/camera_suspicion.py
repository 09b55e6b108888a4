"""`judge_camera`: estimates errors of the camera's calibration from frames.

The pose of a robot's hand is known from its joints to fractions of a
millimetre. So if frames disagree, the most probable cause is the calibration of
the camera: its pose on the hand, its lens or its depth. These errors are
estimated and corrected before a map is built.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.overlap import (
    measure_overlap,
    wrong_frames,
)
from remosplat_drake.reconstruction.alignment.alignment import Alignment, align
from remosplat_drake.reconstruction.alignment.camera_correction import corrected
from remosplat_drake.reconstruction.alignment.camera_errors import (
    COUNT,
    CameraPrior,
)
from remosplat_drake.reconstruction.alignment.camera_summary import (
    words_of_camera,
)
from remosplat_drake.reconstruction.alignment.odometry_prior import (
    OdometryNoise,
)
from remosplat_drake.reconstruction.alignment.refinement import AlignmentConfig
from remosplat_drake.reconstruction.pipeline import Report
from remosplat_drake.reconstruction.uncertainty.bound import LARGEST_SIGMA

LEAST_FRAMES = 5
"""An estimate needs at least this many frames. With fewer frames, errors of the
camera cannot be distinguished from errors of single poses.
"""

_MOST_FRAMES = 16
"""At most this many frames are used for an estimate. More frames would add
little information.
"""

_PRIOR = CameraPrior(
    growth=0.01,
    focal=0.03,
    delay=0.0,
    readout=0.0,
    turn=np.deg2rad(1.0),
    shift=0.005,
)
"""Prior standard deviations of the errors of a manual calibration. Frames
contain no camera velocity, so delays cannot be estimated.
"""


_KINEMATICS = OdometryNoise(
    turn_white=3e-4,
    turn_walk=0.0,
    turn_smooth=0.0,
    white=5e-4,
    walk=0.0,
    steady=0.0,
    smooth=0.0,
)
"""Noise of camera poses from joint positions, if the base is fixed or has exact
odometry.
"""


@dc.dataclass(frozen=True, eq=False)
class Judgement:
    """Camera errors that were estimated from frames.

    Attributes:
        names: Names of the frames.
        errors: The camera's errors, see `camera_errors`, shape (`COUNT`,).
        words: Sentences that describe the errors; empty if there are none.
        problem: Reason why no map can be built from the frames; empty if a map
            can be built.
    """

    names: frozenset[str]
    errors: np.ndarray
    words: str = ""
    problem: str = ""

    def holds_for(self, names: tuple[str, ...]) -> bool:
        """Returns whether the judgement is also valid for other frames.

        Let m be the number of frames that are either among the judged frames or
        among the given frames, but not among both. The judgement is valid if m
        is less than half the number of the given frames. A judgement with a
        problem is valid only if m is zero.

        Args:
            names: Names of the given frames.
        """
        others = self.names.symmetric_difference(names)
        if self.problem:
            return not others
        return 2 * len(others) < len(names)

    def undone(self, capture: Capture) -> Capture:
        """Returns frames after a correction of the camera's errors."""
        return corrected(capture, self.errors) if self.words else capture


def judge_camera(
    capture: Capture,
    names: tuple[str, ...],
    drifts: bool = False,
    report: Report = lambda stage, done, total: None,
) -> Judgement:
    """Estimates the camera's errors from frames of a robot.

    Args:
        capture: The frames, with poses from the robot's joints and odometry.
            With fewer than `LEAST_FRAMES` frames, no errors are estimated.
        names: Names of the frames.
        drifts: Whether the odometry of the robot's base drifts. If so, the
            errors of the poses are also estimated from the frames.
        report: Function that is called with the progress.
    """
    judged = frozenset(names)
    nothing = Judgement(judged, np.zeros(COUNT))
    count = len(capture)
    if count < LEAST_FRAMES:
        return nothing
    few = np.linspace(0, count - 1, min(count, _MOST_FRAMES)).astype(int)
    capture = capture.select(few)

    def aligned(odometry: OdometryNoise | None) -> Alignment:
        config = AlignmentConfig(camera=_PRIOR, odometry=odometry)
        return align(
            capture, config, lambda *done: report("judging the camera", *done)
        )

    alignment = aligned(None if drifts else _KINEMATICS)
    apart = _apart(alignment)
    if apart > LARGEST_SIGMA:
        wrong = wrong_frames(measure_overlap(capture))
        if 0 < len(wrong) < len(capture):
            # Wrong frames are rejected one by one; the remaining frames
            # determine the camera's errors.
            right = np.setdiff1d(np.arange(len(capture)), wrong)
            return judge_camera(capture.select(right), names, drifts, report)
        freely = alignment if drifts else aligned(None)
        return dc.replace(nothing, problem=_problem(apart, _apart(freely)))
    words = _words(alignment)
    return Judgement(judged, alignment.undone, words) if words else nothing


def _apart(alignment: Alignment) -> float:
    """Median distance between the surfaces of different frames [m]."""
    rows = alignment.rows
    points = sum(row.points for row in rows)
    return sum(r.median_after * r.points for r in rows) / max(points, 1)


def _problem(apart: float, freely: float) -> str:
    """Returns why frames with differing surfaces are rejected.

    Args:
        apart: Distance between the frames' surfaces if only the camera has
            errors [m].
        freely: Distance if each frame's pose may have any error, too [m].
    """
    problem = (
        "the frames contradict each other: their surfaces lie"
        f" {1e3 * apart:.0f} mm apart, and no error of the camera's"
        " calibration explains it; "
    )
    if freely <= LARGEST_SIGMA:
        return problem + (
            "the robot's poses from joints and odometry are wrong: check the"
            " joints' zeros, and set mapping.odometry_drift if its base drifts"
        )
    return problem + (
        "wrong poses do not explain it, either: the depth is distorted, or "
        "objects moved; calibrate the camera, or take the frames again"
    )


def _words(alignment: Alignment) -> str:
    """Describes the corrections; empty if there are none."""
    sentences = words_of_camera(alignment)
    parts = [each[0].lower() + each[1:].rstrip(".") for each in sentences]
    return "; ".join(parts) + ": corrected" if parts else ""
