r"""The prior of the given poses: odometry with noise and drift.

Let tau be time, from 0 at the capture's first view to 1 at its last one. The
error of a pose is the sum of white noise, a random walk, a steady drift, and a
smooth drift whose speed is a random walk (Wahba, "Improper priors, spline
smoothing", 1978). The covariance of the errors of views i and j is, for each
coordinate,

    sigma_white^2 [i = j] + sigma_walk^2 m + sigma_steady^2 tau_i tau_j
        + sigma_smooth^2 m^2 (3 M - m) / 2

with m and M the smaller and the larger of tau_i and tau_j.

So if white noise dominates, the mean of all cameras determines the world frame
W; if drift dominates, the first cameras do. The standard deviations are
estimated from the data. The data's normal equations H x = h and the covariance
C give the evidence (MacKay, "Bayesian interpolation", 1992)

    2 ln p = -ln |I + C H| + h^T (H + C^-1)^-1 h,

which is maximised over the eight standard deviations, four of rotation and four
of position.
"""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np
from scipy.linalg import cho_solve, get_lapack_funcs
from scipy.optimize import minimize

from remosplat_drake.reconstruction.alignment.cholesky import lower_factor

_KINDS = 4
"""Number of kinds of noise: white noise, random walk, steady drift and smooth
drift."""

LEAST = np.array([2e-4, 1e-6, 1e-6, 1e-6, 2e-4, 1e-5, 1e-5, 1e-5])
MOST = np.repeat([0.5, 1.0], _KINDS)
"""Limits of the eight deviations of `OdometryNoise`, in its order [rad, m].

White noise has a larger lower limit, since no given poses are exact to
hundredths of a millimetre. Without this limit, a wrong depth scale would seem
certain if it makes the drift smoother by such a small length.
"""

_REFUTED = 3.0
"""Deviations are plausible if the logarithm of their evidence is at most this
much lower than that of the most likely deviations.
"""


@dc.dataclass(frozen=True)
class OdometryNoise:
    """Standard deviations of the errors of given poses.

    Attributes:
        turn_white: White noise of each rotation [rad].
        turn_walk: Random walk of the rotation, at the capture's end [rad].
        turn_steady: Steady drift of the rotation, at the capture's end [rad].
        turn_smooth: Smooth drift of the rotation, at the capture's end [rad].
        white: White noise of each position [m].
        walk: Random walk of the position, at the capture's end [m].
        steady: Steady drift of the position, at the capture's end [m].
        smooth: Smooth drift of the position, at the capture's end [m].
    """

    turn_white: float = 0.01
    turn_walk: float = 0.02
    turn_steady: float = 0.0
    turn_smooth: float = 0.01
    white: float = 0.02
    walk: float = 0.05
    steady: float = 0.05
    smooth: float = 0.05

    @staticmethod
    def of_motions(motion: np.ndarray) -> "OdometryNoise":
        """Makes a first guess of the deviations from errors of poses.

        Args:
            motion: theta_W and t_W of each view, shape (n, 6).
        """
        sizes = np.sqrt(np.square(motion).reshape(-1, 2, 3).mean(axis=(0, 2)))
        return OdometryNoise(*np.repeat(sizes, _KINDS).tolist())

    def covariance(self, n: int) -> np.ndarray:
        """Returns the covariance of n views' errors, (6n, 6n)."""
        return _spread(*self._both(n))

    def precision(self, n: int) -> np.ndarray:
        """Returns the inverse of `covariance`, positive definite."""
        return _spread(*self.inverted(n)[0])

    def inverted(self, n: int) -> tuple[np.ndarray, float]:
        """Inverts the covariances of rotations and positions.

        Both are covariances of one coordinate. Their eigenvalues are at least
        the variance of white noise. Rounding may violate this bound if the
        drift is large.

        Returns:
            The inverses, shape (2, n, n), and the logarithm of the determinant
            of `covariance`.
        """
        values, vectors = np.linalg.eigh(self._both(n))
        white = np.square(_values(self).reshape(2, _KINDS)[:, :1])
        values = np.maximum(values, white)
        root = vectors / np.sqrt(values)[:, None]
        inverses = root @ root.transpose(0, 2, 1)
        return inverses, 3 * float(np.log(values).sum())

    def _both(self, n: int) -> np.ndarray:
        """Covariances of rotations and positions, per coordinate (2, n, n)."""
        squares = np.square(_values(self)).reshape(2, _KINDS)
        return np.einsum("sk,kij->sij", squares, _kernels(n))


def _values(noise: OdometryNoise) -> np.ndarray:
    return np.maximum(dc.astuple(noise), LEAST)


def _kernels(n: int) -> np.ndarray:
    """Covariances of each kind of noise with deviation 1, shape (4, n, n)."""
    tau = np.linspace(0, 1, n) if n > 1 else np.zeros(1)
    least, most = np.minimum(tau, tau[:, None]), np.maximum(tau, tau[:, None])
    smooth = least**2 * (3 * most - least) / 2
    return np.stack([np.eye(n), least, tau * tau[:, None], smooth])


def _spread(turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Expands matrices of one coordinate to all six unknowns of each view."""
    n = len(turn)
    result = np.zeros((n, 6, n, 6))
    for axis in range(3):
        result[:, axis, :, axis] = turn
        result[:, 3 + axis, :, 3 + axis] = shift
    return result.reshape(6 * n, 6 * n)


def estimate_noise(
    H: np.ndarray,
    h: np.ndarray,
    views: int,
    starts: Sequence[OdometryNoise],
    steps: int = 30,
) -> OdometryNoise:
    """Estimates the deviations of given poses by maximising the evidence.

    The evidence may have several maxima, because errors of the camera can have
    the same effect as common motions of all poses. So several searches are
    made, each from different initial deviations.

    Args:
        H: Matrix of the data and of the camera's prior, shape (6n + k, 6n + k).
        h: Right side of the normal equations, shape (6n + k,).
        views: Number n of views.
        starts: Initial deviations of each search; the best result is returned.
        steps: Largest number of steps of each search.
    """
    found = [
        minimize(
            lambda log: _cost(H, h, views, np.exp(log)),
            np.log(np.clip(deviations, 3 * LEAST, 0.5 * MOST)),
            jac=True,
            method="L-BFGS-B",
            bounds=list(zip(np.log(LEAST), np.log(MOST), strict=True)),
            options={"maxiter": steps},
        )
        for deviations in map(_values, starts)
    ]
    best = min(found, key=lambda one: one.fun)
    return OdometryNoise(*np.exp(best.x).tolist())


def plausible_noise(
    H: np.ndarray, h: np.ndarray, views: int, found: OdometryNoise
) -> OdometryNoise:
    """Returns the largest deviations that are still plausible by the evidence.

    For few or weakly constrained poses, the most likely noise is often zero.
    The resulting uncertainty would be too small: surfaces do not constrain all
    directions, and their residuals contain little information on the noise in
    directions in which views can slide. So each deviation is doubled as long as
    the logarithm of the evidence decreases by no more than `_REFUTED`.

    Args:
        H: Matrix of the data and of the camera's prior, shape (6n + k, 6n + k).
        h: Right side of the normal equations, shape (6n + k,).
        views: Number n of views.
        found: The most likely deviations.
    """
    likeliest = _values(found)
    limit = _cost(H, h, views, likeliest, value_only=True)[0] + _REFUTED
    result = likeliest.copy()
    for kind in range(2 * _KINDS):
        trial = likeliest.copy()
        trial[kind] = max(trial[kind], 10 * LEAST[kind])
        while trial[kind] < MOST[kind]:
            if _cost(H, h, views, trial, value_only=True)[0] > limit:
                break
            result[kind] = trial[kind]
            trial[kind] *= 2
    return OdometryNoise(*result.tolist())


def _cost(
    H: np.ndarray,
    h: np.ndarray,
    n: int,
    deviations: np.ndarray,
    value_only: bool = False,
) -> tuple[float, np.ndarray]:
    """Minus ln p, and its derivatives by the deviations' logarithms."""
    inverses, log_C = OdometryNoise(*deviations).inverted(n)
    P = H.copy()
    P[: 6 * n, : 6 * n] += _spread(*inverses)
    L = lower_factor(P)
    x = cho_solve((L, True), h)
    log_P = 2 * np.log(np.diag(L)).sum()
    value = 0.5 * (log_P + log_C - h @ x)
    gradient = np.zeros(2 * _KINDS)
    if value_only:
        return value, gradient
    # A = (C + H^-1)^-1 = C^-1 - C^-1 P^-1 C^-1 and alpha = C^-1 x. C has one
    # block for each coordinate, and only these blocks of A are needed.
    (potri,) = get_lapack_funcs(("potri",), (L,))
    covariance, _ = potri(L, lower=1)
    covariance = covariance[: 6 * n, : 6 * n].reshape(n, 6, n, 6)
    x = x[: 6 * n].reshape(n, 2, 3)
    kernels = _kernels(n)
    for group, inverse in enumerate(inverses):
        axes = range(3 * group, 3 * group + 3)
        below = sum(np.tril(covariance[:, a, :, a]) for a in axes)
        blocks = below + np.tril(below, -1).T
        alpha = inverse @ x[:, group]
        sums = 3 * inverse - inverse @ blocks @ inverse - alpha @ alpha.T
        kinds = slice(_KINDS * group, _KINDS * (group + 1))
        gradient[kinds] = (kernels * sums).sum(axis=(1, 2))
    return value, gradient * np.square(deviations)
