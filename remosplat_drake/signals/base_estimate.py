r"""Drift model of an odometry, with a rate that is correlated over time.

From one camera image to the next, after the time t, the base's pose b = (x, y,
yaw) in W and the drift rate v of the odometry become

    b' = b + (R(b_yaw - o_yaw) (o'_xy - o_xy), o'_yaw - o_yaw) + r v + noise,
    v' = a v + noise,      a = exp(-t / tau),   r = tau (1 - a),

where o is the pose that the odometry measures, and primes mark values at the
later image. The rate is an Ornstein-Uhlenbeck process with the standard
deviation sigma and the correlation time tau. The covariance of the noise of b
and v is the exact integral of this process (Bar-Shalom et al., "Estimation with
applications to tracking and navigation", 2001, section 8.2.3).
"""

import dataclasses as dc

import numpy as np

_WHITE = np.array([5e-4, 5e-4, 2.5e-4])
"""Standard deviations of the errors of x, y and yaw at each camera image [m, m,
rad]. These errors are independent of the drift and of each other."""

OTHER_RUN = 30.0
"""Assumed time between two runs, during which the odometry drifts [s]. The real
time is unknown, since the clocks of two runs have no common origin."""


@dc.dataclass(frozen=True)
class Drift:
    """Parameters of the drift model of a base's odometry.

    Attributes:
        shift: Standard deviation of the drift rate of the position [m/s].
        turn: Standard deviation of the drift rate of the heading [rad/s].
        memory: Correlation time tau of the drift rates [s].
    """

    shift: float
    turn: float
    memory: float = 60.0

    @property
    def variances(self) -> np.ndarray:
        """Variances of the drift rates of x, y and yaw, shape (3,)."""
        return np.square([self.shift, self.shift, self.turn])

    def noise(self, seconds: float) -> np.ndarray:
        """Returns the covariance of the process noise of (b, v), (6, 6).

        Args:
            seconds: The duration [s].
        """
        tau, a = self.memory, np.exp(-seconds / self.memory)
        own = tau**2 * (2 * seconds / tau - 3 + 4 * a - a**2)
        rows = [[own, tau * (1 - a) ** 2], [tau * (1 - a) ** 2, 1 - a**2]]
        Q = np.kron(np.array(rows), np.diag(self.variances))
        Q[:3, :3] += np.diag(_WHITE**2)
        return Q


@dc.dataclass(frozen=True, eq=False)
class BaseEstimate:
    """Estimate of the base's pose and of the drift rate of its odometry.

    Attributes:
        time: Time of the estimate, by the diagram's clock [s].
        X_OB: The base's pose by odometry, shape (3,) [m, rad].
        X_WB: The base's pose b in W, shape (3,) [m, rad].
        rate: The drift rate v, shape (3,) [m/s, rad/s].
        covariance: Covariance of (b, v), shape (6, 6).
    """

    time: float
    X_OB: np.ndarray
    X_WB: np.ndarray
    rate: np.ndarray
    covariance: np.ndarray

    @staticmethod
    def first(time: float, X_OB: np.ndarray, drift: Drift) -> "BaseEstimate":
        """Returns the initial estimate: W is the odometry's frame O."""
        P = np.kron(np.diag([0.0, 1.0]), np.diag(drift.variances))
        X_OB = np.array(X_OB, float)
        return BaseEstimate(time, X_OB, X_OB, np.zeros(3), P).certain()

    def certain(self) -> "BaseEstimate":
        """Returns this estimate with an exact pose, which defines W."""
        P = np.zeros((6, 6))
        P[:3, :3] = np.diag(_WHITE**2)
        P[3:, 3:] = self.covariance[3:, 3:]
        return dc.replace(self, covariance=P)

    @property
    def deviations(self) -> np.ndarray:
        """Standard deviations of x, y and yaw, shape (3,) [m, rad]."""
        return np.sqrt(np.diag(self.covariance)[:3])


def predicted(
    before: BaseEstimate, X_OB: np.ndarray, time: float, drift: Drift
) -> BaseEstimate:
    """Predicts the estimate at a later time from odometry and drift.

    Args:
        before: The earlier estimate.
        X_OB: The base's pose by odometry at the later time, shape (3,) [m,
            rad].
        time: The later time [s]. If it is earlier than that of `before`,
            another run has begun.
        drift: Drift model of the odometry.
    """
    seconds = time - before.time if time >= before.time else OTHER_RUN
    x, F = moved(before.X_WB, before.rate, before.X_OB, X_OB, seconds, drift)
    P = F @ before.covariance @ F.T + drift.noise(seconds)
    return BaseEstimate(time, np.array(X_OB, float), x[:3], x[3:], P)


def moved(
    X_WB: np.ndarray,
    rate: np.ndarray,
    X_OB: np.ndarray,
    X_OB_after: np.ndarray,
    seconds: float,
    drift: Drift,
) -> tuple[np.ndarray, np.ndarray]:
    """Computes the expected pose b' and drift rate v' after a motion.

    Args:
        X_WB: The base's pose b, shape (3,) [m, rad].
        rate: The drift rate v, shape (3,) [m/s, rad/s].
        X_OB: The pose o by odometry at the start, shape (3,) [m, rad].
        X_OB_after: The pose o' by odometry at the end, shape (3,) [m, rad].
        seconds: Time between the two poses [s].
        drift: Drift model, with the correlation time.

    Returns:
        The vector (b', v'), shape (6,), and its Jacobian with respect to (b,
        v), shape (6, 6).
    """
    a = np.exp(-seconds / drift.memory)
    reach = drift.memory * (1 - a)
    turn = X_WB[2] - X_OB[2]
    c, s = np.cos(turn), np.sin(turn)
    x, y, yaw = X_OB_after - X_OB
    yaw = (yaw + np.pi) % (2 * np.pi) - np.pi
    shift = np.array([c * x - s * y, s * x + c * y])
    state = np.concatenate([X_WB + [*shift, yaw] + reach * rate, a * rate])
    F = np.kron([[1.0, reach], [0.0, a]], np.eye(3))
    F[:2, 2] = -shift[1], shift[0]
    return state, F
