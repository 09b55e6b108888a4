"""Finds common mistakes about camera poses in a capture.

A reader of captures must assume the direction of poses (camera-to-world or
world-to-camera), the directions of the camera's axes (OpenCV or OpenGL), the
order of a quaternion's numbers (xyzw or wxyz) and the unit of lengths. If one
assumption is wrong, the views contradict each other. After its correction, they
agree.
"""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.overlap import Overlap, measure_overlap

_FLIP_YZ = np.diag([1.0, -1.0, -1.0, 1.0])

GOOD_AGREEMENT = 0.8
"""If poses are right, the depths of neighbouring views agree at this fraction
of the compared points or more."""

_LEFT = 0.5
"""A mistake explains a disagreement if, after its correction, less than this
fraction of the disagreement remains.
"""


@dc.dataclass(frozen=True)
class Mistake:
    """A wrong assumption about poses, and its correction.

    Attributes:
        words: Description of the wrong poses, as part of a warning.
        remedy: Description of the correction, for a report.
        undo_poses: Function from the wrong poses to the right poses X_WC, both
            of shape (n, 4, 4).
    """

    words: str
    remedy: str
    undo_poses: Callable[[np.ndarray], np.ndarray]

    def undo(self, capture: Capture) -> Capture:
        """Returns the capture with the right poses."""
        return dc.replace(capture, X_WC=self.undo_poses(capture.X_WC))


def find_mistake(
    capture: Capture, overlap: Overlap
) -> tuple[Mistake, Overlap] | None:
    """Finds the mistake about poses that explains why views disagree.

    Args:
        capture: The views, whose depths are assumed correct, except for their
            unit.
        overlap: Overlap with the unchanged poses.

    Returns:
        The mistake, and the overlap after its correction; None if no mistake
        explains the disagreement.
    """
    disagreement = 1 - np.nan_to_num(overlap.agreement)
    best, supported = None, overlap.supported
    for mistake in MISTAKES:
        without = measure_overlap(mistake.undo(capture))
        fits = (
            without.agreement >= GOOD_AGREEMENT
            and 1 - without.agreement < _LEFT * disagreement
        )
        if fits and without.supported > supported:
            best, supported = (mistake, without), without.supported
    return best


def _flip(X_WC: np.ndarray) -> np.ndarray:
    return X_WC @ _FLIP_YZ


def _reorder(shift: int, flip: bool) -> Callable[[np.ndarray], np.ndarray]:
    """Rotates a quaternion's four numbers by `shift` places.

    Args:
        shift: 1 if the file has xyzw and was read as wxyz; -1 if it has wxyz
            and was read as xyzw.
        flip: Whether the reader converted the camera's axes afterwards.
    """

    def undo(X_WC: np.ndarray) -> np.ndarray:
        read = _flip(X_WC) if flip else X_WC
        wxyz = Rotation.from_matrix(read[:, :3, :3]).as_quat(scalar_first=True)
        right = Rotation.from_quat(
            np.roll(wxyz, shift, axis=1), scalar_first=True
        )
        X = read.copy()
        X[:, :3, :3] = right.as_matrix()
        return _flip(X) if flip else X

    return undo


def _scale(factor: float) -> Callable[[np.ndarray], np.ndarray]:
    def undo(X_WC: np.ndarray) -> np.ndarray:
        X = X_WC.copy()
        X[:, :3, 3] *= factor
        return X

    return undo


_INVERSE = "poses look like world-to-camera, not camera-to-world"
_TURNED = (
    "camera axes look like OpenGL's (y up, z backward) where OpenCV's (y down,"
    " z forward) were expected, or the other way round"
)
_ORDER = "quaternions look like {} read as {}"
_LENGTHS = "camera positions look {:g} times too {} for the depths ({})"


def _lengths(times: float, too: str, words: str) -> Mistake:
    factor = times if too == "small" else 1 / times
    return Mistake(
        _LENGTHS.format(times, too, words),
        f"multiplied camera positions by {factor:g}",
        _scale(factor),
    )


MISTAKES = (
    Mistake(_TURNED, "turned the camera axes", _flip),
    Mistake(_INVERSE, "inverted the poses", np.linalg.inv),
    Mistake(
        f"{_INVERSE}, and {_TURNED}",
        "inverted the poses and turned the camera axes",
        lambda X: _flip(np.linalg.inv(X)),
    ),
    *(
        Mistake(
            _ORDER.format(*orders),
            "reordered the quaternions",
            _reorder(shift, flip),
        )
        for orders, shift in ((("xyzw", "wxyz"), 1), (("wxyz", "xyzw"), -1))
        for flip in (False, True)
    ),
    _lengths(1000, "large", "millimetres read as metres"),
    _lengths(1000, "small", "metres read as millimetres"),
    _lengths(5, "small", "depths / 1000 that are / 5000"),
    _lengths(5, "large", "depths / 5000 that are / 1000"),
)
"""All mistakes that are tried.

No correction turns the axes before it inverts the poses, because it would only
rotate the world frame W.
"""
