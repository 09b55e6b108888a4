"""`Pace`: the speed of a simulation beside the wall clock."""

from collections import deque

_SPAN = 3.0
"""Time over which the pace is taken [s]."""


class Pace:
    """The share of real time that the last seconds ran at."""

    def __init__(self):
        self._moments: deque[tuple[float, float]] = deque()

    def add(self, time: float, now: float) -> None:
        """Takes in a moment; all are forgotten if time goes backwards.

        Args:
            time: Time of the diagram [s].
            now: Time of the wall clock [s].
        """
        if self._moments and time < self._moments[-1][0]:
            self._moments.clear()
        self._moments.append((time, now))
        while now - self._moments[0][1] > _SPAN:
            self._moments.popleft()

    @property
    def share(self) -> float | None:
        """Seconds of the diagram in a second; None while that is not known."""
        if not self._moments:
            return None
        (time, now), (later, end) = self._moments[0], self._moments[-1]
        if end - now < 0.5 * _SPAN:
            return None
        return (later - time) / (end - now)
