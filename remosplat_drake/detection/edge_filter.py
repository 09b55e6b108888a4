"""Estimates an object's velocity from the motion of its six outermost faces.

If an object is only partly visible, or changes its shape, the centre of its
visible points has another velocity than the object. Its outlines are a better
measure: if the object translates, its least and its greatest x have the same
velocity. If they do not, their difference bounds the error of the velocity.

Each of the six faces has its own Kalman filter, with a position and a rate. The
filter models accelerations as random. Their standard deviation is the largest
allowed acceleration, so that the filter also covers a constant acceleration of
this size.
"""

import dataclasses as dc

import numpy as np

SIGMAS = 3.5
"""The bound on a velocity error is this many standard deviations."""

_GATE = 5.0
"""A face has jumped if its observed position differs from the prediction by
more than this many standard deviations.
"""


@dc.dataclass(frozen=True, eq=False)
class Edges:
    """Positions and rates of the six faces of an object's axis-aligned box.

    Attributes:
        place: Positions of the faces, shape (2, 3) [m].
        rate: Rates of the faces, shape (2, 3) [m/s].
        P: Covariance of position and rate of each face, shape (3, 2, 3):
            variance of the position, covariance of position and rate, variance
            of the rate.
        time: Time of the state [s].
    """

    place: np.ndarray
    rate: np.ndarray
    P: np.ndarray
    time: float

    @staticmethod
    def first(
        place: np.ndarray, deviation: float, max_speed: float, time: float
    ) -> "Edges":
        """Makes a state from one observation, with unknown rates."""
        P = np.zeros((3, 2, 3))
        P[0], P[2] = deviation**2, (max_speed / SIGMAS) ** 2
        return Edges(place, np.zeros((2, 3)), P, time)

    def after(self, time: float, max_acceleration: float) -> "Edges":
        """Predicts the faces at a later time."""
        t = time - self.time
        a, c, d = self.P
        noise = max_acceleration**2 * t**2
        P = np.stack(
            [
                a + 2 * t * c + t**2 * d + noise * t**2 / 4,
                c + t * d + noise * t / 2,
                d + noise,
            ]
        )
        return Edges(self.place + t * self.rate, self.rate, P, time)

    def seen(
        self, place: np.ndarray, deviation: float, max_speed: float
    ) -> "Edges":
        """Updates the faces with an observation at the time of the state.

        Faces that have jumped, because the visible part changed, are reset.

        Args:
            place: Observed positions, shape (2, 3) [m].
            deviation: Standard deviation of the observed positions [m].
            max_speed: Greatest speed of objects [m/s].
        """
        a, c, d = self.P
        off, total = place - self.place, a + deviation**2
        gain, lead = a / total, c / total
        rate = self.rate + lead * off
        P = np.stack([(1 - gain) * a, (1 - gain) * c, d - lead * c])
        jumped = off**2 > _GATE**2 * total
        new = Edges.first(place, deviation, max_speed, self.time)
        return Edges(
            np.where(jumped, place, self.place + gain * off),
            np.where(jumped, self.rate, np.clip(rate, -max_speed, max_speed)),
            np.where(jumped, new.P, P),
            self.time,
        )

    def velocity(self, max_speed: float) -> tuple[np.ndarray, float]:
        """Returns the velocity of the object.

        Args:
            max_speed: Greatest speed of objects [m/s].

        Returns:
            The velocity, shape (3,) [m/s], and a bound on its error at any
            point of the object [m/s].
        """
        weight = 1 / self.P[2]
        v = (weight * self.rate).sum(axis=0) / weight.sum(axis=0)
        # A face that was just reset does not contradict the opposite face.
        settled = self.P[2] < (0.5 * max_speed / SIGMAS) ** 2
        apart = np.where(settled, np.abs(self.rate - v), 0).max(axis=0)
        spread = np.sqrt(self.P[2].min(axis=0))
        error = np.linalg.norm(apart) + SIGMAS * float(spread.max())
        return v, min(float(error), max_speed + float(np.linalg.norm(v)))


def outline(p_W: np.ndarray) -> np.ndarray:
    """Finds the outermost faces of points, without a few outliers.

    Args:
        p_W: Points in W, shape (n, 3) [m].

    Returns:
        Least and greatest coordinates, shape (2, 3) [m].
    """
    few = min(len(p_W) - 1, max(1, len(p_W) // 20))
    lower = np.partition(p_W, few, axis=0)[: few + 1].mean(axis=0)
    upper = -np.partition(-p_W, few, axis=0)[: few + 1].mean(axis=0)
    return np.stack([lower, upper])
