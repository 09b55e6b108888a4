"""`Pace`: measures a simulation's speed relative to the wall clock."""

from collections import deque

_SPAN = 3.0
"""Time over which the speed is averaged [s]."""


class Pace:
    """A simulation's speed relative to real time, over the last seconds."""

    def __init__(self):
        self._moments: deque[tuple[float, float]] = deque()

    def add(self, time: float, now: float) -> None:
        """Adds a sample; drops all earlier samples if time goes backwards.

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
        """Simulated seconds per second; None while it is unknown."""
        if not self._moments:
            return None
        (time, now), (later, end) = self._moments[0], self._moments[-1]
        if end - now < 0.5 * _SPAN:
            return None
        return (later - time) / (end - now)
