"""Depth consistency between overlapping views of a capture.

Points of one view are projected into another view and compared with its depth
image. A point behind the measured surface may be occluded. A point in front of
the surface is a contradiction, since the other view measured free space at it.
"""

import dataclasses as dc
from itertools import permutations

import numpy as np

from remosplat_drake.capture.capture import Capture

TOLERANCE = 0.02
"""Fraction of a depth by which agreeing depths may differ."""

_SAMPLES = 400
_COARSE = 40
"""Number of points of a view that are compared with other views, and number of
points that the search for neighbouring views uses.
"""

_NEIGHBOURS = 4
_MIN_OVERLAP = 0.3
"""Views are neighbours if each sees at least this fraction of the other's
points.
"""

_MIN_JUDGED = 20
"""A pair of views is judged only if the views share at least this many points.
"""

MIN_AGREEMENT = 0.5
"""If the poses of two views are correct, their depths agree at this fraction of
the compared points or more."""

_MAX_JUMP = 0.05
"""There is an edge between neighbouring pixels if their depths differ by more
than this fraction."""


@dc.dataclass(frozen=True, eq=False)
class Overlap:
    """Comparison of the depths of m pairs of neighbouring views.

    Attributes:
        pairs: Indices of the views (a, b) with a < b, shape (m, 2).
        agreeing: Number of points, of both views of a pair, whose depth agrees
            with the other view, shape (m,).
        contradicting: Number of points, of both views of a pair, that are in
            front of the other view's surface, shape (m,).
        differences: Absolute differences between the depth of a point and that
            of the other view's surface, for all compared points of all pairs
            [m].
        supported: Fraction of all views' points that agree with the depth of at
            least one neighbouring view.
    """

    pairs: np.ndarray
    agreeing: np.ndarray
    contradicting: np.ndarray
    differences: np.ndarray
    supported: float

    def __len__(self) -> int:
        return len(self.pairs)

    @property
    def agreement(self) -> float:
        """Fraction of compared points that agree; NaN if there is none."""
        judged = int(self.agreeing.sum() + self.contradicting.sum())
        return int(self.agreeing.sum()) / judged if judged else np.nan

    @property
    def agreements(self) -> np.ndarray:
        """Agreement of each pair, shape (m,); NaN for few shared points."""
        judged = self.agreeing + self.contradicting
        shares = judged >= _MIN_JUDGED
        return np.where(shares, self.agreeing / np.maximum(judged, 1), np.nan)

    @property
    def median(self) -> float:
        """Median absolute difference of depths [m]; NaN if there are none."""
        if not len(self.differences):
            return np.nan
        return float(np.median(self.differences))

    def within(self, distance: float) -> float:
        """Returns the fraction of points with differences < distance [m]."""
        if not len(self.differences):
            return np.nan
        return float((self.differences < distance).mean())


def measure_overlap(
    capture: Capture, seed: int = 0, tolerance: float = TOLERANCE
) -> Overlap:
    """Compares each view's depth with that of its neighbours.

    Args:
        capture: Posed RGB-D images, in any order.
        seed: Seed of the random choice of points.
        tolerance: Fraction of a depth by which agreeing depths may differ.
    """
    p_C = sample_points(capture, _SAMPLES, np.random.default_rng(seed))
    pairs = neighbours(capture, p_C[:, :_COARSE])
    agreeing = np.zeros(len(pairs), int)
    contradicting = np.zeros(len(pairs), int)
    supported = np.zeros(p_C.shape[:2], bool)
    differences = [np.zeros(0)]
    for i, pair in enumerate(pairs):
        for a, b in (pair, pair[::-1]):
            z, measured = compare(capture, p_C[a], a, b)
            margin = tolerance * measured
            agrees = np.abs(z - measured) < margin
            contradicts = z <= measured - margin
            agreeing[i] += agrees.sum()
            contradicting[i] += contradicts.sum()
            supported[a] |= agrees
            differences.append(np.abs(z - measured)[agrees | contradicts])
    return Overlap(
        pairs=pairs,
        agreeing=agreeing,
        contradicting=contradicting,
        differences=np.concatenate(differences),
        supported=float(supported.mean()) if supported.size else 0.0,
    )


def supported_fractions(
    capture: Capture, seed: int = 0, tolerance: float = TOLERANCE
) -> np.ndarray:
    """Computes the fraction of each view's points that another view confirms.

    Args:
        capture: The n views.
        seed: Seed of the random choice of points.
        tolerance: Fraction of a depth by which agreeing depths may differ.

    Returns:
        Fractions of the views' points, shape (n,); 0 for a view without
        depth.
    """
    p_C = sample_points(capture, _SAMPLES, np.random.default_rng(seed))
    supported = np.zeros(p_C.shape[:2], bool)
    for a, b in permutations(range(len(capture)), 2):
        z, measured = compare(capture, p_C[a], a, b)
        supported[a] |= np.abs(z - measured) < tolerance * measured
    return supported.mean(axis=1)


def wrong_frames(overlap: Overlap) -> np.ndarray:
    """Finds views that disagree with all of their neighbours.

    Views without neighbours are not included, since nothing contradicts them.

    Returns:
        Indices of these views, ascending.
    """
    agreements = overlap.agreements
    views = np.unique(overlap.pairs[np.isfinite(agreements)])
    confirmed = np.unique(overlap.pairs[agreements >= MIN_AGREEMENT])
    return np.setdiff1d(views, confirmed)


def neighbours(capture: Capture, p_C: np.ndarray) -> np.ndarray:
    """Finds pairs of views with large overlap.

    Args:
        capture: The n views.
        p_C: Some points of each view in its camera frame, (n, k, 3) [m] or NaN.

    Returns:
        Indices of the views, shape (m, 2).
    """
    n, shared = len(capture), shared_fractions(capture, p_C)
    best = np.argsort(-shared, axis=1, kind="stable")[:, :_NEIGHBOURS]
    a = np.repeat(np.arange(n), best.shape[1])
    b = best.ravel()
    pairs = np.sort(np.stack([a, b], axis=1), axis=1)
    return np.unique(pairs[shared[a, b] >= _MIN_OVERLAP], axis=0)


def shared_fractions(capture: Capture, p_C: np.ndarray) -> np.ndarray:
    """Computes the fraction of points that each pair of views shares.

    Occlusion is ignored.

    Args:
        capture: The n views.
        p_C: Some points of each view in its camera frame, (n, k, 3) [m] or NaN.

    Returns:
        For each pair of views, the fraction of one view's points that project
        into the other's image; the smaller of both directions. Shape (n, n); 0
        on the diagonal.
    """
    n = len(capture)
    seen = np.zeros((n, n))
    for a in range(n):
        seen[a] = _fraction_seen(capture, to_world(capture, p_C[a], a))
    shared = np.minimum(seen, seen.T)
    np.fill_diagonal(shared, 0)
    return shared


def sample_points(
    capture: Capture, count: int, rng: np.random.Generator
) -> np.ndarray:
    """Draws points of random known pixels of each view, in its camera frame.

    Args:
        capture: The n views.
        count: Number of points of each view.
        rng: Source of randomness.

    Returns:
        Shape (n, count, 3) [m]; NaN for a view without depth.
    """
    p_C = np.full((len(capture), count, 3), np.nan)
    for view, depth in enumerate(capture.depth):
        known = np.flatnonzero(depth)
        if not len(known):
            continue
        pixels = rng.choice(known, count)
        row, column = np.divmod(pixels, capture.size[1])
        K, z = capture.K[view], depth.flat[pixels]
        p_C[view, :, 0] = (column + 0.5 - K[0, 2]) / K[0, 0] * z
        p_C[view, :, 1] = (row + 0.5 - K[1, 2]) / K[1, 1] * z
        p_C[view, :, 2] = z
    return p_C


def compare(
    capture: Capture, p_C: np.ndarray, a: int, b: int
) -> tuple[np.ndarray, np.ndarray]:
    """Compares depths of points of view a with measurements of view b.

    The measured depth is interpolated on the surface between four pixels;
    1 / z is linear in the image of a plane.

    Args:
        capture: The views.
        p_C: Points in the camera frame of a, shape (k, 3) [m].
        a: Index of the points' view.
        b: Index of the view that they are projected into.

    Returns:
        Depths of the points in b's camera frame, and b's measured depths at
        their pixels, both of shape (k,) [m]; NaN where b has measured no
        surface.
    """
    K, image = capture.K[b], capture.depth[b]
    height, width = capture.size
    p_B = to_camera(capture, to_world(capture, p_C, a), b)
    z = np.where(p_B[:, 2] > 0, p_B[:, 2], np.nan)
    u = K[0, 0] * p_B[:, 0] / z + K[0, 2] - 0.5
    v = K[1, 1] * p_B[:, 1] / z + K[1, 2] - 0.5
    inside = (u >= 0) & (v >= 0) & (u < width - 1) & (v < height - 1)
    u, v = np.where(inside, u, 0), np.where(inside, v, 0)
    column, row = u.astype(int), v.astype(int)
    corners = np.stack(
        [image[row + i, column + j] for i in (0, 1) for j in (0, 1)]
    ).astype(float)
    low, high = corners.min(axis=0), corners.max(axis=0)
    inside &= (low > 0) & (high - low < _MAX_JUMP * low)
    s, t = u - column, v - row
    weights = np.stack([(1 - t) * (1 - s), (1 - t) * s, t * (1 - s), t * s])
    inverse = (weights / np.where(inside, corners, 1)).sum(axis=0)
    return np.where(inside, z, np.nan), np.where(inside, 1 / inverse, np.nan)


def to_world(capture: Capture, p_C: np.ndarray, view: int) -> np.ndarray:
    """Transforms points (k, 3) from a view's camera frame to W [m]."""
    X_WC = capture.X_WC[view]
    return p_C @ X_WC[:3, :3].T + X_WC[:3, 3]


def to_camera(capture: Capture, p_W: np.ndarray, view: int) -> np.ndarray:
    """Transforms points (k, 3) from W to a view's camera frame [m]."""
    X_WC = capture.X_WC[view]
    return (p_W - X_WC[:3, 3]) @ X_WC[:3, :3]


def _fraction_seen(capture: Capture, p_W: np.ndarray) -> np.ndarray:
    """Returns the fraction of the points in each view's image, (n,)."""
    X_WC = capture.X_WC
    p_C = (p_W[None] - X_WC[:, None, :3, 3]) @ X_WC[:, :3, :3]
    image = p_C @ capture.K.transpose(0, 2, 1)
    z = image[..., 2]
    height, width = capture.size
    with np.errstate(invalid="ignore", divide="ignore"):
        u, v = image[..., 0] / z, image[..., 1] / z
        inside = (z > 0) & (u >= 0) & (v >= 0) & (u < width) & (v < height)
    known = max(int(np.isfinite(p_W[:, 0]).sum()), 1)
    return inside.sum(axis=1) / known
