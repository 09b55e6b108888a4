"""`Path`: a path through configurations, with the greatest speeds along it."""

import dataclasses as dc

import numpy as np


@dc.dataclass(frozen=True, eq=False)
class Path:
    """A sequence of straight segments through configurations.

    Lengths of the path are sums in which a radian counts like a metre.

    Attributes:
        q: The corners, shape (k, n_q) [rad, m].
        s: Arc length at each corner, shape (k,).
        v: Greatest speed ds/dt at each corner, shape (k,) [1/s]. Between two
            corners, v^2 is linear in s. It is None for a path without speeds,
            on which the speed is proportional to the remaining length.
        a: Greatest dv/dt at each corner for a robot at rest, and for a robot at
            the speed v, shape (k, 2) [1/s^2]. For speeds in between, it is
            linear in the square of the speed. It is None for a path without
            speeds.
    """

    q: np.ndarray
    s: np.ndarray
    v: np.ndarray | None = None
    a: np.ndarray | None = None

    @staticmethod
    def through(q: np.ndarray) -> "Path":
        """Makes a path through given corners.

        Args:
            q: The corners, shape (k, n_q) [rad, m]. Equal consecutive corners
                count as one.
        """
        q = np.array(q, float)
        step = np.linalg.norm(np.diff(q, axis=0), axis=1)
        q = q[np.concatenate([[True], step > 1e-9])]
        step = np.linalg.norm(np.diff(q, axis=0), axis=1)
        return Path(q, np.concatenate([[0.0], np.cumsum(step)]))

    def __deepcopy__(self, memo) -> "Path":
        return self

    @property
    def length(self) -> float:
        """Arc length of the whole path."""
        return float(self.s[-1])

    def at(self, s: float) -> np.ndarray:
        """Returns the configuration at an arc length, shape (n_q,).

        Args:
            s: Arc length; values beyond the ends are clipped.
        """
        k = int(np.searchsorted(self.s, s, side="right")) - 1
        k = min(max(k, 0), len(self.s) - 2)
        if k < 0:
            return self.q[0]
        span = self.s[k + 1] - self.s[k]
        share = min(max((s - self.s[k]) / span, 0.0), 1.0)
        return self.q[k] + share * (self.q[k + 1] - self.q[k])

    def until(self, s: float) -> "Path":
        """Returns the part of the path up to an arc length.

        Args:
            s: Arc length at which the part ends.
        """
        before = self.q[self.s < s]
        return Path.through(np.vstack([before, self.at(s)]))

    def nearest(self, q: np.ndarray) -> tuple[float, float]:
        """Finds the point of the path that is nearest to a configuration.

        Args:
            q: The configuration, shape (n_q,) [rad, m].

        Returns:
            The arc length of the point, and its distance from the
            configuration. If several points are equally near, the point is the
            one with the largest arc length.
        """
        if len(self.q) == 1:
            return 0.0, float(np.linalg.norm(q - self.q[0]))
        step = np.diff(self.q, axis=0)
        span = np.diff(self.s)
        share = np.einsum("kj,kj->k", q - self.q[:-1], step) / span**2
        share = np.clip(share, 0.0, 1.0)
        apart = np.linalg.norm(self.q[:-1] + share[:, None] * step - q, axis=1)
        k = len(apart) - 1 - int(np.argmin(apart[::-1]))
        return float(self.s[k] + share[k] * span[k]), float(apart[k])
