"""`TopicValues`: the latest values of ROS topics, which may expire."""

import math
from typing import Generic, TypeVar

Value = TypeVar("Value")


def expiry_of(expiry: float | None) -> float:
    """Converts a configured expiry time [s]; None becomes inf.

    Args:
        expiry: A topic's value expires after this time without messages [s];
            None if values never expire.
    """
    return math.inf if expiry is None else expiry


class TopicValues(Generic[Value]):
    """The latest values of topics, which expire without new messages."""

    def __init__(self, expiry: float):
        """Starts without values.

        Args:
            expiry: A topic's value expires after this time without messages
                [s].
        """
        self._expiry = expiry
        self._values: dict[str, tuple[Value, float]] = {}

    def put(self, name: str, value: Value, t: float) -> None:
        """Stores a value of a topic.

        Args:
            name: Name of the topic.
            value: Its value.
            t: Time of its arrival, by a monotonic clock [s].
        """
        self._values[name] = (value, t)

    def known(self, t: float) -> dict[str, Value]:
        """Returns the values that are valid at a time t [s], keyed by topic."""
        return {
            name: value
            for name, (value, _) in self._values.items()
            if self.silence(name, t) <= self._expiry
        }

    def silence(self, name: str, t: float) -> float:
        """Returns the time since a topic's latest message [s]; inf without one.

        Args:
            name: Name of the topic.
            t: The time [s].
        """
        came = self._values[name][1] if name in self._values else -math.inf
        return t - came
