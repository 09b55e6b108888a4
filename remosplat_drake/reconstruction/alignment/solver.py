"""Gauss-Newton equations for poses and shared camera errors, and solution."""

import dataclasses as dc

import numpy as np
from scipy.linalg import cho_solve, solve_triangular

from remosplat_drake.reconstruction.alignment.camera_errors import NO_ERRORS
from remosplat_drake.reconstruction.alignment.cholesky import lower_factor
from remosplat_drake.reconstruction.alignment.odometry_prior import (
    OdometryNoise,
)
from remosplat_drake.reconstruction.alignment.pair_kernel import (
    POSE,
    pair_equations,
    pair_residuals,
)
from remosplat_drake.reconstruction.alignment.perturbation import (
    assemble,
    difference,
    perturbed,
)
from remosplat_drake.reconstruction.alignment.view_stack import ViewStack

_STRIDE = 7
"""The spread of all residuals is estimated from every `_STRIDE`-th residual."""


_SYSTEMATIC = 10.0
"""All variances are multiplied by this factor. It allows for errors that the
residuals of a pair have in common, for example if noise hides a crease. It was
determined on rendered captures with known truth.
"""


_KNOWN = 2.0
"""A direction of the unknowns is constrained if its information exceeds the
apparent information from noise by this factor.
"""


@dc.dataclass(frozen=True)
class Level:
    """One stage of a refinement from coarse to fine.

    Attributes:
        gate: Points with a larger residual are ignored [m].
        width: Least width of the robust weight [m].
        least_cosine: Points are ignored if the cosine of the angle between the
            normals of the two surfaces is less than this.
        steps: At most this many Gauss-Newton steps are made.
    """

    gate: float
    width: float
    least_cosine: float
    steps: int


@dc.dataclass(eq=False)
class State:
    """Poses and camera errors at a step of the refinement.

    Attributes:
        X_WC: Poses, shape (n, 4, 4).
        errors: Errors that all images share, see `camera_errors`, shape (k,);
            empty for a camera that is assumed exact.
        undone: The amount of these errors that has been corrected in the
            images, shape (k,).
    """

    X_WC: np.ndarray
    errors: np.ndarray = dc.field(default_factory=NO_ERRORS.copy)
    undone: np.ndarray = dc.field(default_factory=NO_ERRORS.copy)

    @property
    def pose(self) -> np.ndarray:
        """Poses without their last rows, for the kernels, (n, 3, 4)."""
        return np.ascontiguousarray(self.X_WC[:, :3])

    @property
    def left(self) -> np.ndarray:
        """Part of `errors` that is not corrected in the images, (k,)."""
        return self.errors - self.undone

    def unknowns(self, given: np.ndarray) -> np.ndarray:
        """Returns errors of the given poses and the camera, (6n + k,)."""
        return np.append(difference(self.X_WC, given).ravel(), self.errors)

    def moved(self, step: np.ndarray) -> "State":
        """Returns the state after a Gauss-Newton step of all unknowns."""
        poses = step[: POSE * len(self.X_WC)].reshape(-1, POSE)
        return State(
            perturbed(self.X_WC, poses),
            self.errors + step[POSE * len(self.X_WC) :],
            self.undone,
        )


@dc.dataclass(frozen=True, eq=False)
class Equations:
    """Normal equations of all data, linearised at a state, and of each pair.

    Attributes:
        H: Matrix of all unknowns, shape (6n + k, 6n + k).
        g: Gradient, shape (6n + k,).
        pair_H: Matrices of the pairs, shape (m, 6 + k, 6 + k).
        pair_g: Gradients of the pairs, shape (m, 6 + k).
        count: Number of residuals of each pair, shape (m,).
        shared: Number of residuals of each pair that have as much information
            as one independent residual, shape (m,); H and g have been divided
            by it.
    """

    H: np.ndarray
    g: np.ndarray
    pair_H: np.ndarray
    pair_g: np.ndarray
    count: np.ndarray
    shared: np.ndarray


def residual_spread(
    stack: ViewStack, state: State, pairs: np.ndarray, level: Level
) -> float:
    """Estimates the ratio of residuals to their known standard deviations.

    The estimate is robust, and at least 1.
    """
    kept = -(-stack.point.shape[1] // _STRIDE)
    values = np.empty((len(pairs), 2, kept, 2))
    pair_residuals(
        stack, state.pose, state.left, pairs, level.gate, level.least_cosine,
        _STRIDE, values,
    )  # fmt: skip
    ratio = np.abs(values[..., 0] / values[..., 1])
    ratio = ratio[np.isfinite(ratio)]
    return max(1.4826 * float(np.median(ratio)), 1.0) if len(ratio) else 1.0


def equations(
    stack: ViewStack,
    state: State,
    pairs: np.ndarray,
    level: Level,
    spread: float,
    correlation: float,
) -> Equations:
    """Sums the normal equations of all pairs at a state.

    Args:
        stack: The views.
        state: Poses, and errors of the camera.
        pairs: Indices of views (a, b), shape (m, 2).
        level: The stage of the refinement, whose limits the residuals must
            meet.
        spread: The result of `residual_spread`.
        correlation: The result of `estimate_correlation`.
    """
    m, unknowns = len(pairs), POSE + len(state.errors)
    H, g = np.empty((m, unknowns, unknowns)), np.empty((m, unknowns))
    tilts, count = np.empty_like(H), np.empty(m)
    pair_equations(
        stack,
        state.pose,
        state.left,
        pairs,
        level.gate,
        level.least_cosine,
        spread,
        level.width,
        H,
        g,
        tilts,
        count,
    )
    H, g = _without_tilts(H, g, tilts)
    shared = _SYSTEMATIC * np.maximum(_reuse(stack, pairs, count), correlation)
    matrix, gradient = assemble(
        H / shared[:, None, None], g / shared[:, None], state.X_WC, pairs
    )
    return Equations(matrix, gradient, H, g, count, shared)


def _without_tilts(
    H: np.ndarray, g: np.ndarray, tilts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Subtracts the apparent information from noise of normals.

    In front of a wall, noisy normals seem to constrain a view that can slide,
    because noise in J adds its variance to H = sum of J J^T. Directions in
    which this variance dominates are ignored.
    """
    values, vectors = np.linalg.eigh(H)
    pretended = np.einsum("mia,mij,mja->ma", vectors, tilts, vectors)
    known = values > _KNOWN * np.maximum(pretended, 0)
    values = np.where(known, values - pretended, 0)
    along = np.where(known, np.einsum("mia,mi->ma", vectors, g), 0)
    return (
        np.einsum("mia,ma,mja->mij", vectors, values, vectors),
        np.einsum("mia,ma->mi", vectors, along),
    )


def _reuse(
    stack: ViewStack, pairs: np.ndarray, count: np.ndarray
) -> np.ndarray:
    """Returns the factor by which each pair repeats information, (m,).

    The noise of a view affects the residuals of all its pairs. So its pose
    cannot be more certain than the independent windows of its image allow.
    """
    total = np.zeros(len(stack.count))
    np.add.at(total, pairs.ravel(), np.repeat(count, 2))
    often = 0.5 * total / np.maximum(stack.independent, 1)
    return np.maximum(often[pairs].mean(axis=1), 1)


@dc.dataclass(frozen=True, eq=False)
class Posterior:
    """Normal distribution of the unknowns, given data and prior.

    Attributes:
        mean: Mean errors of the given poses and of the camera, (6n + k,).
        covariance: Covariance of these errors, shape (6n + k, 6n + k).
        noise: Noise of the given poses.
        response: Derivative of the poses' mean errors by the camera's errors,
            shape (6n, k).
    """

    mean: np.ndarray
    covariance: np.ndarray
    noise: OdometryNoise
    response: np.ndarray

    def camera_without(
        self, none: np.ndarray, bias: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Computes the camera's errors, given that some of them are zero.

        If an error is truly zero, its estimate consists of noise and of a bias
        of the model. If the bias were ignored, the other errors would have to
        explain each estimate that exceeds its noise. Errors that the data
        hardly determine would then become arbitrarily large.

        Args:
            none: Mask of the errors that are zero, shape (k,).
            bias: Standard deviation of the bias of each estimate, shape (k,).

        Returns:
            Mean and standard deviation of each error, shape (k,) each.
        """
        poses = len(self.response)
        own = self.mean[poses:]
        C = self.covariance[poses:, poses:]
        estimates = C[np.ix_(none, none)] + np.diag(bias[none] ** 2)
        gain = np.linalg.solve(estimates, C[none]).T
        mean = np.where(none, 0.0, own - gain @ own[none])
        variance = np.diag(C) - (gain * C[:, none]).sum(axis=1)
        return mean, np.where(none, 0.0, np.sqrt(np.maximum(variance, 0)))

    def poses_with(self, errors: np.ndarray) -> np.ndarray:
        """Returns the poses' mean errors, given the camera's errors.

        Args:
            errors: The camera's errors, shape (k,).

        Returns:
            theta_W and t_W of each view, shape (n, 6) [rad, m].
        """
        poses = len(self.response)
        moved = self.response @ (errors - self.mean[poses:])
        return (self.mean[:poses] + moved).reshape(-1, POSE)


def posterior(
    data: Equations,
    x: np.ndarray,
    views: int,
    noise: OdometryNoise,
    known: tuple[np.ndarray, np.ndarray],
) -> Posterior:
    """Solves the data's equations, linearised at x, together with the prior's.

    Args:
        data: The data's equations, linearised at x.
        x: Errors of the given poses and of the camera, (6n + k,).
        views: Number n of views.
        noise: Noise of the given poses.
        known: Matrix and gradient of other prior knowledge, at x.
    """
    H = data.H + known[0]
    h = H @ x - data.g - known[1]
    poses = POSE * views
    H[:poses, :poses] += noise.precision(views)
    L = lower_factor(H)
    covariance = cho_solve((L, True), np.eye(len(H)), check_finite=False)
    return Posterior(
        mean=cho_solve((L, True), h, check_finite=False),
        covariance=covariance,
        noise=noise,
        response=-solve_triangular(
            L[:poses, :poses], L[poses:, :poses].T, lower=True, trans=1
        ),
    )


def estimate_correlation(
    data: Equations, result: Posterior, *, default: float, weight: float = 20
) -> float:
    """Estimates the number of residuals per independent residual.

    Errors of neighbouring pixels are correlated, and so are all residuals of a
    pair of distorted images. The estimate compares the solution of each pair
    alone with the joint solution. If residuals were independent, the sum of g^T
    H^-1 g over all pairs would have a chi^2 distribution. Its degrees of
    freedom would be the number of directions that the pairs constrain, minus
    the number of unknowns that the data determine. The ratio of the sum to this
    number is the estimate.

    Args:
        data: Equations at the solution.
        result: The solution.
        default: The prior value, which dominates if there are few pairs.
        weight: Weight of the default, in degrees of freedom.
    """
    values, vectors = np.linalg.eigh(data.pair_H)
    along = np.einsum("mji,mj->mi", vectors, data.pair_g)
    known = values > 1e-6 * np.maximum(values[:, -1:], 1e-12)
    chi2 = np.where(known, along**2 / np.where(known, values, 1), 0).sum()
    fitted = (result.covariance * data.H).sum()
    freedom = max(known.sum() - fitted, 0.0)
    return float((default * weight + chi2) / (weight + freedom))
