"""`align`: refines poses and the camera's own errors from the depth images.

All views of a surface, near or distant, must place it at the same position. So
all poses, and the errors that all images share (see `camera_errors`), are
refined together: Gauss-Newton minimises point-to-plane distances, from coarse
to fine. The given poses are treated as an odometry, whose noise and drift are
estimated from the data.
"""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.camera_errors import (
    COUNT,
    OFFSET,
    SCALE,
    CameraPrior,
)
from remosplat_drake.reconstruction.alignment.odometry_prior import (
    OdometryNoise,
)
from remosplat_drake.reconstruction.alignment.refinement import (
    AlignmentConfig,
    Refinement,
    held_out,
)
from remosplat_drake.reconstruction.alignment.residual_table import (
    ResidualRow,
    distances_of_pairs,
    is_better,
    residual_rows,
)
from remosplat_drake.reconstruction.alignment.solver import (
    State,
)

_IMPLAUSIBLE = 5.0
"""A camera error is implausible if its estimate exceeds this multiple of its
prior standard deviation.
"""


@dc.dataclass(frozen=True, eq=False)
class Alignment:
    """An aligned capture, with the uncertainty of its cameras.

    The unknowns are theta_W [rad] and t_W [m] of each view, view after view,
    then the k errors that all images share. The true pose of a camera is
    exp(theta_W) R_WC, p_WC + t_W. The true position of a point is, to first
    order, its position in the returned capture plus the displacements of
    `camera_errors`.

    Attributes:
        capture: The refined capture, or the given one if it was not accepted.
        undone: Amount of each camera error that was corrected in the capture,
            shape (k,).
        error: Expected value of the unknowns, shape (6n + k,). It is 0 if the
            refinement was accepted; otherwise it is the estimate that was
            rejected.
        covariance: Covariance of the unknowns, shape (6n + k, 6n + k).
        noise: Noise of the given poses.
        shared: Number of correlated residuals that have as much information as
            one independent residual.
        rows: Residuals before and after the refinement, grouped by the distance
            between the two cameras. They are equal if the refinement was not
            accepted.
        groups: Number of groups of views; views of different groups share no
            surface.
        accepted: Whether the refinement was accepted. It is accepted if
            held-out pairs of views agree better after it, and if the estimated
            errors of the camera are plausible.
    """

    capture: Capture
    undone: np.ndarray
    error: np.ndarray
    covariance: np.ndarray
    noise: OdometryNoise
    shared: float
    rows: list[ResidualRow]
    groups: int
    accepted: bool

    @property
    def scale(self) -> float:
        """Factor by which measured depths were multiplied."""
        return 1 + float(self.undone[SCALE])

    @property
    def offset(self) -> float:
        """The correction that was added to measured depths [m]."""
        return float(self.undone[OFFSET])

    @property
    def deviations(self) -> np.ndarray:
        """Standard deviations of the camera's errors, shape (k,)."""
        return np.sqrt(np.diag(self.covariance)[-COUNT:])

    def draws(self, count: int = 64, seed: int = 0) -> np.ndarray:
        """Draws random errors of all unknowns from their normal distribution.

        Returns:
            Shape (count, 6n + k).
        """
        values, vectors = np.linalg.eigh(self.covariance)
        root = vectors * np.sqrt(np.maximum(values, 0))
        normal = np.random.default_rng(seed).standard_normal((count, len(root)))
        return self.error + normal @ root.T


def align(
    capture: Capture,
    config: AlignmentConfig | None = None,
    report: Callable[[int, int], None] = lambda done, total: None,
) -> Alignment:
    """Refines the poses of a capture and the errors that all images share.

    Args:
        capture: Posed RGB-D images, in the order in which they were taken.
        config: Settings; None: the defaults.
        report: Function that is called with the number of completed steps and
            the number of all steps.

    Raises:
        FieldError: A measured length refers to a pixel without depth.
    """
    config = config or AlignmentConfig()
    refinement = Refinement(capture, config)
    before = refinement.stack
    result, state = refinement.run(report)
    pairs = refinement.pairs
    judging = held_out(state, pairs)
    if not judging.any():
        judging[:] = True
    start = State(capture.X_WC, np.zeros(COUNT), np.zeros(COUNT))
    old = distances_of_pairs(before, start, pairs)
    state = refinement.freed(state)
    new = distances_of_pairs(refinement.stack, state, pairs)
    accepted = bool(config.lengths) or (
        is_plausible(state.errors, config.camera)
        and is_better(old[judging], new[judging])
    )
    error = result.mean
    if accepted:
        error = result.mean - state.unknowns(refinement.given)
        capture = dc.replace(refinement.image, X_WC=state.X_WC)
    return Alignment(
        capture=capture,
        undone=state.errors if accepted else np.zeros(COUNT),
        error=error,
        covariance=result.covariance,
        noise=result.noise,
        shared=refinement.shared,
        rows=residual_rows(state.X_WC, pairs, old, new if accepted else old),
        groups=_groups(len(capture), pairs),
        accepted=accepted,
    )


def is_plausible(errors: np.ndarray, prior: CameraPrior) -> bool:
    """Returns whether a camera's estimated errors are plausible.

    Estimates may be implausible if poses drift, because the data then hardly
    determine the scale of the scene. A smaller scene makes all distances
    between views smaller, so the views seem to agree better.

    Args:
        errors: The errors, in the order of `camera_errors`, shape (k,).
        prior: The camera's prior.
    """
    return bool((np.abs(errors) <= _IMPLAUSIBLE * prior.deviations()).all())


def _groups(n: int, pairs: np.ndarray) -> int:
    """Counts the groups of views; no pair of views connects two groups."""
    ones = np.ones(len(pairs))
    graph = coo_array((ones, (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    return int(connected_components(graph, directed=False)[0])
