"""How fast a thing moves, by the motion of its six outermost faces.

A thing that a camera sees a part of only, or that changes its shape, has no
centre that moves as it does. Its outlines do: where all of it moves alike, so
do its lowest and its highest x. Where they do not, the difference is how much
the velocity may be wrong.

Each of the six is a Kalman filter of its own, with a place and a rate, that
takes accelerations for random, with the greatest allowed as their standard
deviation: then a steady acceleration of that size is covered, too.
"""

import dataclasses as dc

import numpy as np

SIGMAS = 3.5
"""Standard deviations that a velocity may be off."""

_GATE = 5.0
"""Standard deviations beyond which a face has jumped, not moved."""


@dc.dataclass(frozen=True, eq=False)
class Edges:
    """Places and rates of the faces x, y, z of least and of greatest value.

    Attributes:
        place: Places, shape (2, 3) [m].
        rate: Their rates, shape (2, 3) [m/s].
        P: Covariance of place and rate, for each: variance of the place, their
            covariance, variance of the rate, shape (3, 2, 3).
        time: When [s].
    """

    place: np.ndarray
    rate: np.ndarray
    P: np.ndarray
    time: float

    @staticmethod
    def first(
        place: np.ndarray, deviation: float, max_speed: float, time: float
    ) -> "Edges":
        """Starts with what is seen once: nobody knows how fast it is."""
        P = np.zeros((3, 2, 3))
        P[0], P[2] = deviation**2, (max_speed / SIGMAS) ** 2
        return Edges(place, np.zeros((2, 3)), P, time)

    def after(self, time: float, max_acceleration: float) -> "Edges":
        """Predicts them."""
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
        """Takes in where they are seen at this very time.

        Faces that have jumped, because more or less of the thing is seen than
        before, begin anew.

        Args:
            place: Where they are seen, shape (2, 3) [m].
            deviation: Standard deviation of that [m].
            max_speed: No thing is faster [m/s].
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
        """Tells the velocity of the whole.

        Args:
            max_speed: No thing is faster [m/s].

        Returns:
            The velocity, shape (3,) [m/s], and by how much it may be wrong at
            any point of the thing [m/s].
        """
        weight = 1 / self.P[2]
        v = (weight * self.rate).sum(axis=0) / weight.sum(axis=0)
        # A face that has only begun says nothing against the other one.
        settled = self.P[2] < (0.5 * max_speed / SIGMAS) ** 2
        apart = np.where(settled, np.abs(self.rate - v), 0).max(axis=0)
        spread = np.sqrt(self.P[2].min(axis=0))
        error = np.linalg.norm(apart) + SIGMAS * float(spread.max())
        return v, min(float(error), max_speed + float(np.linalg.norm(v)))


def outline(p_W: np.ndarray) -> np.ndarray:
    """Finds the outermost faces of points, but for a few stray ones.

    Args:
        p_W: Points in W, shape (n, 3) [m].

    Returns:
        Least and greatest coordinates, shape (2, 3) [m].
    """
    few = min(len(p_W) - 1, max(1, len(p_W) // 20))
    lower = np.partition(p_W, few, axis=0)[: few + 1].mean(axis=0)
    upper = -np.partition(-p_W, few, axis=0)[: few + 1].mean(axis=0)
    return np.stack([lower, upper])
