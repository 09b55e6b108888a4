"""Checks a capture's images: their intrinsics, depths and colours."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import MIN_DEPTH_FRACTION, Capture
from remosplat_drake.capture.checks.findings import (
    COLOURS,
    DEPTH_RANGE,
    DEPTH_UNIT,
    EMPTY_DEPTH,
    INTRINSICS,
    NO_DEPTH,
    ONE_PLANE,
    WARNING,
    Finding,
    list_frames,
)
from remosplat_drake.capture.checks.frame_shifts import SHIFTS
from remosplat_drake.capture.checks.overlap import sample_points, to_world
from remosplat_drake.capture.checks.registration import (
    Registration,
    edge_correlation,
)

_FOV_RANGE = (20.0, 130.0)
"""Least and largest field of view of RGB-D cameras and phones, with a margin
[deg].
"""

_MAX_OFF_CENTRE = 0.15
"""A principal point is plausible if it is at most this far from the image's
centre, as a fraction of the image's size."""

_ALIKE = 0.1
"""Two numbers count as equal if their relative difference is less than this."""

_SQUARE = 0.1
"""An image counts as square if |log(width / height)| is at most this."""

_DEPTH_RANGE = (0.1, 10.0)
"""Plausible median depths in a robot's workspace [m]."""

_GOOD_CORRELATION = 0.3
"""Depths and colours belong to the same frame if the correlation of their edges
exceeds this.
"""

_MUCH_BETTER, _MIN_GAIN = 1.5, 0.05
"""Ratio r and difference d of correlations. Let c be the correlation of colours
with the depths of their own frame. The colours belong to another frame if their
correlation with the depths of that frame exceeds r c + d.
"""

_PLANE, _ON_PLANE = 0.02, 0.95
"""A capture shows only one plane if at least this fraction of its points (the
second number) is within this distance of a plane (the first number) [m].
"""

_MAX_EMPTY = 0.2
"""There is no warning if at most this fraction of the depth images is empty. A
few empty images are normal, since a camera may be too close to all surfaces in
view.
"""

_UNITS = (
    (1e3, "millimetres read as metres"),
    (1e-3, "metres read as millimetres"),
    (5.0, "1 / 5000 m read as millimetres"),
    (0.2, "millimetres read as 1 / 5000 m"),
)
"""Factors by which depths may be too large, and the mistakes that cause them.
"""


def judge_camera(capture: Capture, fov_deg: np.ndarray) -> list[Finding]:
    """Judges whether intrinsics fit the images.

    Args:
        capture: The capture.
        fov_deg: Median horizontal and vertical field of view, shape (2,)
            [deg].
    """
    height, width = capture.size
    K = np.median(capture.K, axis=0)
    size, focal, center = np.array([width, height]), K[[0, 1], [0, 1]], K[:2, 2]
    off = np.abs(center / size - 0.5).max()
    if off > _MAX_OFF_CENTRE:
        return [_judge_centre(center, size, float(off))]
    low, high = _FOV_RANGE
    findings = []
    if not (low < fov_deg.min() and fov_deg.max() < high):
        problem = (
            f"fields of view of {fov_deg[0]:.0f} x {fov_deg[1]:.0f} degrees"
            f" are implausible ({low:.0f} to {high:.0f} are usual); check that "
            "the focal lengths belong to images of this size"
        )
        findings.append(Finding(INTRINSICS, problem))
    stretch, aspect = focal[0] / focal[1], width / height
    if abs(np.log(aspect)) > _SQUARE and (
        abs(abs(np.log(stretch)) - abs(np.log(aspect))) < _ALIKE
    ):
        problem = (
            f"the focal lengths {focal[0]:.0f} and {focal[1]:.0f} have the"
            f" ratio of the images' sides ({width} x {height}), but should be"
            " equal, since pixels are square; perhaps one focal length was"
            " scaled by the wrong side, or f_x and f_y were exchanged: "
            "correct f_x and f_y in the file"
        )
        findings.append(Finding(INTRINSICS, problem))
    return findings


def _judge_centre(center: np.ndarray, size: np.ndarray, off: float) -> Finding:
    """Judges a principal point that is far from the images' centre."""
    problem = (
        f"the principal point lies {100 * off:.0f} % of the image's size away "
        "from its centre"
    )
    # Principal points have errors of some per cent, so the scale is
    # approximate.
    scales = 2 * center / size
    scale = float(scales.mean())
    if np.abs(scales - scale).max() < _ALIKE * abs(scale):
        problem += f", as in images about {scale:.2g} times as large"
    elif np.abs(2 * center / size[::-1] - 1).max() < _ALIKE:
        problem += (
            ", as in images turned by 90 degrees: exchange c_x and"
            " c_y, and f_x and f_y, in the file"
        )
        return Finding(INTRINSICS, problem)
    problem += ": give the intrinsics for the images' own size"
    return Finding(INTRINSICS, problem)


def judge_depth(capture: Capture, median: float) -> list[Finding]:
    """Judges whether there is depth, and whether it is in metres.

    Args:
        capture: The capture.
        median: Median of the known depths [m]; NaN if there are none.
    """
    known = (capture.depth > 0).mean(axis=(1, 2))
    if known.mean() < MIN_DEPTH_FRACTION:
        problem = f"only {100 * known.mean():.1f} % of the pixels have a depth"
        return [Finding(NO_DEPTH, problem)]
    return [*_judge_empty(capture, known), *_judge_unit(median)]


def _judge_empty(capture: Capture, known: np.ndarray) -> list[Finding]:
    empty = np.flatnonzero(known < MIN_DEPTH_FRACTION)
    if len(empty) <= _MAX_EMPTY * len(known):
        return []
    problem = (
        f"{len(empty)} of {len(known)} depth images are empty:"
        f" {list_frames(empty, capture)}"
    )
    return [
        Finding(
            EMPTY_DEPTH,
            problem,
            WARNING,
            frames=tuple(empty.tolist()),
            remedy="removed the frames without depth",
            repair=lambda capture: without(capture, empty),
        )
    ]


def _judge_unit(median: float) -> list[Finding]:
    low, high = _DEPTH_RANGE
    if low <= median <= high:
        return []
    guesses = [unit for unit in _UNITS if low <= median / unit[0] <= high]
    problem = (
        f"a median depth of {median:.4g} m is implausible ({low} to {high:.0f}"
        " m are usual)"
    )
    if not guesses:
        return [Finding(DEPTH_RANGE, problem, WARNING)]
    factor, words = guesses[0]

    def repair(capture: Capture) -> Capture:
        depth = (capture.depth / factor).astype(np.float32)
        return dc.replace(capture, depth=depth)

    return [
        Finding(
            DEPTH_UNIT,
            f"{problem}: looks like {words}",
            remedy=f"divided depths by {factor:g}",
            repair=repair,
        )
    ]


def judge_registration(
    capture: Capture, registration: Registration | None
) -> list[Finding]:
    """Judges whether the edges of colour and depth coincide.

    Args:
        capture: The capture.
        registration: Result of `measure_registration`; None if there is too
            little data.
    """
    shifts = [s for s in SHIFTS if s.moves_colour and len(capture) > 2]
    as_is = 0.0 if registration is None else registration.unshifted
    for shift in shifts if as_is < _GOOD_CORRELATION else ():
        undone = edge_correlation(capture, shift.step)
        if undone > _MUCH_BETTER * as_is + _MIN_GAIN:
            problem = (
                f"{shift.words}: the correlation of edges is {as_is:.2f}, but"
                f" {undone:.2f} after its correction"
            )
            return [
                Finding(
                    COLOURS, problem, remedy=shift.remedy, repair=shift.undo
                )
            ]
    if registration is None or not registration.is_off:
        return []
    right, down = registration.shift
    problem = (
        "colour and depth are not registered: their edges match best with"
        f" the colours moved {right:+d} columns and {down:+d} rows"
        f" (correlation {registration.correlation:.2f}; without this shift"
        f" {registration.unshifted:.2f})"
    )
    return [Finding(COLOURS, problem)]


def judge_shape(capture: Capture) -> list[Finding]:
    """Judges whether a capture shows more than one plane."""
    p_C = sample_points(capture, 100, np.random.default_rng(0))
    p_W = np.concatenate(
        [to_world(capture, p, view) for view, p in enumerate(p_C)]
    )
    p_W = p_W[np.isfinite(p_W[:, 0])]
    if len(p_W) < 3:
        return []
    height = np.zeros(len(p_W))
    for _ in range(3):
        near = p_W[np.abs(height) <= np.percentile(np.abs(height), 95)]
        middle = near.mean(axis=0)
        normal = np.linalg.svd(near - middle, full_matrices=False)[2][2]
        height = (p_W - middle) @ normal
    on_plane = float((np.abs(height) < _PLANE).mean())
    if on_plane < _ON_PLANE:
        return []
    problem = (
        f"{100 * on_plane:.0f} % of the measured points lie on one plane;"
        " errors of poses parallel to it cannot be detected"
    )
    return [Finding(ONE_PLANE, problem, WARNING)]


def without(capture: Capture, frames: np.ndarray) -> Capture:
    """Returns the capture without the frames of the given indices."""
    kept = np.ones(len(capture), bool)
    kept[frames] = False
    return capture.select(kept)
