"""`TopicValues`: latest values of ROS topics, until these are silent."""

import math
from typing import Generic, TypeVar

Value = TypeVar("Value")


def expiry_of(expiry: float | None) -> float:
    """Returns a silence as a number [s]: infinite where None says never."""
    return math.inf if expiry is None else expiry


class TopicValues(Generic[Value]):
    """The latest values of topics; the value of a silent topic is dropped."""

    def __init__(self, expiry: float):
        """Starts without a value, which counts as unknown.

        Args:
            expiry: Silence from which on a topic says nothing any more [s].
        """
        self._expiry = expiry
        self._values: dict[str, tuple[Value, float]] = {}

    def put(self, name: str, value: Value, t: float) -> None:
        """Keeps a value that came at a time t, by a monotonic clock [s].

        Args:
            name: Name of the topic.
            value: Its value.
            t: When it came [s].
        """
        self._values[name] = (value, t)

    def known(self, t: float) -> dict[str, Value]:
        """Returns the values that count at a time t [s], by topic."""
        return {
            name: value
            for name, (value, _) in self._values.items()
            if self.silence(name, t) <= self._expiry
        }

    def silence(self, name: str, t: float) -> float:
        """Returns for how long a topic is silent at a time t; inf if always.

        Args:
            name: Name of the topic.
            t: The time [s].
        """
        came = self._values[name][1] if name in self._values else -math.inf
        return t - came
