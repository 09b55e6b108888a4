"""Measures the disagreement of distant views on shared surfaces.

Noise differs from pixel to pixel, but an error of a pose or of the depth's
scale moves all points of a view. So for each pair of views, a rigid motion is
fitted that aligns the points of one view with the surfaces of the other view
(point to plane). The displacement by this motion is compared with the
displacement that noise alone would cause.

If every depth is too large by a fraction s, the surfaces of views at p_WA and
p_WB are displaced relative to each other by s (p_WB - p_WA). This distinguishes
an error of the scale from errors of poses.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.overlap import (
    sample_points,
    shared_fractions,
    to_camera,
    to_world,
)
from remosplat_drake.capture.checks.tangent_planes import (
    TangentPlanes,
    planes_under,
)

_SAMPLES, _COARSE = 300, 40
"""Number of points of a view that are compared with another view, and number of
points that the search for overlapping views uses.
"""

_PAIRS = 300
"""By default, at most this many pairs of views are compared."""

_MIN_SHARED = 0.15
"""Two views form a pair if they share at least this fraction of their
points."""

_MIN_POINTS = 40
"""A fit of six degrees of freedom needs at least this many shared points."""

_REACH = 0.1
"""Surfaces of two views are the same surface only if their distance at a point
is less than this [m]."""

_THROUGH, _THROUGH_FAR = 0.05, 0.03
"""Length [m], and fraction of the depth, whose sum is the margin of free space.
A view shows free space at a point if the depth that it measured at the point's
pixel exceeds the point's depth by more than this margin.
"""

_TIMES_OFFSET = 5.0
"""The length `_THROUGH` is increased to this multiple of the median
disagreement of views.
"""

_SAME_NORMAL = 0.85
"""Surfaces of two views are the same surface only if the cosine of the angle
between their normals exceeds this."""

_ITERATIONS = 6
"""A reweighted fit makes this many iterations. It converges after four
iterations.
"""

_LEAST_SCATTER = 1e-5
"""This length is added to the scatter of a fit's residuals, so that it is never
zero [m]."""


@dc.dataclass(frozen=True, eq=False)
class WideBaselines:
    """Disagreement of m pairs of n views, ordered by their baselines.

    Attributes:
        frames: Number of views n.
        pairs: Indices of the views (a, b) with a < b, shape (m, 2).
        baseline: Distance between the cameras, shape (m,) [m].
        offset: The rigid motion that best aligns the views' surfaces moves the
            shared points; root mean square of these displacements along the
            normals, shape (m,) [m]. NaN if the views share too few points.
        noise: The offset that noise alone would have caused, shape (m,) [m].
        scale: Fraction by which depths are too large relative to the poses.
        unscaled: Offsets that remain after a correction of the scale, shape
            (m,) [m].
        judged: Number of points of a, and of b, that the pair's other view
            confirms or contradicts, shape (m, 2).
        through: Number of these points that are in the other view's free space,
            shape (m, 2).
    """

    frames: int
    pairs: np.ndarray
    baseline: np.ndarray
    offset: np.ndarray
    noise: np.ndarray
    scale: float
    unscaled: np.ndarray
    judged: np.ndarray
    through: np.ndarray

    @property
    def compared(self) -> np.ndarray:
        """Mask of the pairs that share enough points, shape (m,), bool."""
        return np.isfinite(self.offset)


@dc.dataclass(frozen=True, eq=False)
class _Matches:
    """Points of a pair of views that lie on both views' surfaces.

    Attributes:
        p_W: The points, shape (k, 3) [m].
        normal_W: Normals of the surfaces, shape (k, 3).
        gap: Distance from b's to a's surface along these normals, shape (k,)
            [m].
        found: Numbers of these points that a, and that b, measured.
        beyond: Distances of the other view's surface behind other points of a,
            and of b, minus `_THROUGH_FAR` of their depth, shape (k',) each [m].
    """

    p_W: np.ndarray
    normal_W: np.ndarray
    gap: np.ndarray
    found: tuple[int, ...]
    beyond: tuple[np.ndarray, ...]

    def through(self, margin: float) -> list[int]:
        """Counts points of each view that are in the other's free space."""
        return [int((beyond > margin).sum()) for beyond in self.beyond]

    def judged(self, margin: float) -> list[int]:
        """Counts points of each view that the other confirms or refutes."""
        through = self.through(margin)
        return [a + b for a, b in zip(self.found, through, strict=True)]


def measure_wide_baselines(
    capture: Capture, seed: int = 0, most: int = _PAIRS
) -> WideBaselines:
    """Measures the disagreement of near and distant views on surfaces.

    Args:
        capture: Posed RGB-D images, in any order.
        seed: Seed of the random choice of points.
        most: Greatest number of pairs of views that are compared.
    """
    p_C = sample_points(capture, _SAMPLES, np.random.default_rng(seed))
    pairs, baseline = _choose_pairs(capture, p_C[:, :_COARSE], most)
    planes = {
        view: planes_under(capture, view, p_C[view])
        for view in np.unique(pairs).tolist()
    }
    matches = [_match(capture, planes, *pair) for pair in pairs.tolist()]
    along = [
        m.normal_W @ (capture.X_WC[b, :3, 3] - capture.X_WC[a, :3, 3])
        for m, (a, b) in zip(matches, pairs, strict=True)
    ]
    gaps = [m.gap for m in matches]
    scale = _fit_scale(
        np.concatenate([[], *along]), np.concatenate([[], *gaps])
    )
    motions = np.array([_motion(m, m.gap) for m in matches]).reshape(-1, 2)
    unscaled = [
        _motion(m, m.gap - scale * x)[0]
        for m, x in zip(matches, along, strict=True)
    ]
    margin = max(_THROUGH, _TIMES_OFFSET * _median(motions[:, 0]))
    return WideBaselines(
        frames=len(capture),
        pairs=pairs,
        baseline=baseline,
        offset=motions[:, 0],
        noise=motions[:, 1],
        scale=scale,
        unscaled=np.array(unscaled),
        judged=np.array([m.judged(margin) for m in matches], int).reshape(
            -1, 2
        ),
        through=np.array([m.through(margin) for m in matches], int).reshape(
            -1, 2
        ),
    )


def share_surfaces(capture: Capture, a: int, b: int, seed: int = 0) -> bool:
    """Returns whether two views share enough surfaces for a comparison.

    Args:
        capture: The views.
        a: Index of one of the views.
        b: Index of the other view.
        seed: Seed of the random choice of points.
    """
    two = capture.select(np.array([a, b]))
    p_C = sample_points(two, _SAMPLES, np.random.default_rng(seed))
    planes = {view: planes_under(two, view, p_C[view]) for view in (0, 1)}
    return len(_match(two, planes, 0, 1).gap) >= _MIN_POINTS


def _choose_pairs(
    capture: Capture, p_C: np.ndarray, most: int
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of views (m, 2), and their ascending baselines (m,) [m]."""
    a, b = np.nonzero(np.triu(shared_fractions(capture, p_C) >= _MIN_SHARED))
    p_WC = capture.X_WC[:, :3, 3]
    baseline = np.linalg.norm(p_WC[b] - p_WC[a], axis=1)
    order = np.argsort(baseline, kind="stable")
    if len(order) > most:
        order = order[np.linspace(0, len(order) - 1, most).astype(int)]
    return np.stack([a, b], axis=1)[order], baseline[order]


def _match(
    capture: Capture, planes: dict[int, TangentPlanes], a: int, b: int
) -> _Matches:
    """Finds the points of each view that lie on the other view's surfaces."""
    parts, found, beyond = [], [], []
    for this, other, sign in ((a, b, 1.0), (b, a, -1.0)):
        own = planes[this].select(np.isfinite(planes[this].p_C[:, 0]))
        p_W = to_world(capture, own.p_C, this)
        p_D = to_camera(capture, p_W, other)
        seen = planes_under(capture, other, p_D)
        normal_W = seen.normal_C @ capture.X_WC[other, :3, :3].T
        own_W = own.normal_C @ capture.X_WC[this, :3, :3].T
        # The plane's inverse depth on the point's ray, times the point's depth.
        ratio = (seen.plane * p_D).sum(axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            gap = (ratio - 1) / np.linalg.norm(seen.plane, axis=1)
            same = (np.abs(gap) < _REACH) & (
                (normal_W * own_W).sum(axis=1) > _SAME_NORMAL
            )
            z = p_D[:, 2]
            behind = z / ratio - z - _THROUGH_FAR * z
        parts.append((p_W[same], normal_W[same], sign * gap[same]))
        found.append(int(same.sum()))
        beyond.append(behind[~same & (behind > 0)])
    p_W, normal_W, gap = (
        np.concatenate(part) for part in zip(*parts, strict=True)
    )
    return _Matches(p_W, normal_W, gap, tuple(found), tuple(beyond))


def _motion(matches: _Matches, gap: np.ndarray) -> tuple[float, float]:
    """The displacement by the motion that closes gaps, and its noise [m].

    Robust least squares with the weights of Geman and McClure. Degrees of
    freedom that the surfaces do not constrain are ignored. NaN if there are too
    few points.
    """
    if len(gap) < _MIN_POINTS:
        return np.nan, np.nan
    normal_W = matches.normal_W
    arm = matches.p_W - matches.p_W.mean(axis=0)
    size = max(float(np.sqrt(np.square(arm).sum(axis=1).mean())), 1e-6)
    J = np.hstack([normal_W, np.cross(arm / size, normal_W)])
    weight = np.ones(len(gap))
    moved, left, scatter = gap, gap, 0.0
    for _ in range(_ITERATIONS):
        half = np.sqrt(weight)
        x = np.linalg.lstsq(J * half[:, None], gap * half, rcond=1e-2)[0]
        moved = J @ x
        left = gap - moved
        scatter, weight = _robust(left)
    inner = np.abs(left) < 3 * scatter
    offset = float(np.sqrt(np.square(moved[inner]).mean()))
    return offset, scatter * float(np.sqrt(J.shape[1] / inner.sum()))


def _fit_scale(along: np.ndarray, gap: np.ndarray) -> float:
    """Robust slope of the gaps over the baselines along the normals."""
    if not len(gap):
        return 0.0
    scale, weight = 0.0, np.ones(len(gap))
    for _ in range(2 * _ITERATIONS):
        square = float((weight * along**2).sum())
        scale = float((weight * along * gap).sum()) / max(square, 1e-12)
        _, weight = _robust(gap - scale * along)
    return scale


def _robust(left: np.ndarray) -> tuple[float, np.ndarray]:
    """Scatter of a fit's residuals [m], and the next weights."""
    scatter = 1.4826 * float(np.median(np.abs(left))) + _LEAST_SCATTER
    return scatter, 1 / np.square(1 + np.square(left / (3 * scatter)))


def _median(offsets: np.ndarray) -> float:
    """Median of the known offsets [m]; 0 if none is known."""
    known = offsets[np.isfinite(offsets)]
    return float(np.median(known)) if len(known) else 0.0
