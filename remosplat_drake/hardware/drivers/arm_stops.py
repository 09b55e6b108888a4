"""`ArmStops`: reads an arm's stops from ROS topics."""

import math
from typing import NamedTuple

from drake import lcmt_panda_status

from remosplat_drake.hardware.drivers.topic_values import (
    TopicValues,
    expiry_of,
)
from remosplat_drake.hardware.ros_config import (
    EMERGENCY_STOP,
    MODE,
    Ros2ArmTopics,
)


class ArmHold(NamedTuple):
    """State of an arm's stops.

    Attributes:
        mode: The arm's mode, a value of lcmt_panda_status.robot_mode.
        reason: Reason why the arm must not move; empty if it may move.
    """

    mode: int = lcmt_panda_status.kMove
    reason: str = ""


class ArmStops:
    """The latest values of topics that report whether an arm may move."""

    def __init__(self, topics: Ros2ArmTopics):
        """Starts without values, so the arm counts as stopped."""
        self._topics = topics
        self._values = TopicValues[str](expiry_of(topics.stop_expiry))

    def put(self, field: str, value: bool | int | str, t: float) -> None:
        """Stores a value of a topic.

        Args:
            field: `EMERGENCY_STOP` or `MODE`.
            value: Value of its topic.
            t: Time of its arrival, by a monotonic clock [s].
        """
        text = str(value)
        self._values.put(
            field, text.lower() if isinstance(value, bool) else text, t
        )

    def hold(self, t: float) -> ArmHold:
        """Returns the state according to the topics at a time t [s]."""
        topics, known = self._topics, self._values.known(t)
        if known.get(EMERGENCY_STOP) == "true":
            reason = f"{topics.emergency_stop}: emergency stop"
            return ArmHold(lcmt_panda_status.kUserStopped, reason)
        for field, topic in topics.stops.items():
            if field not in known:
                silence = f"for more than {topics.stop_expiry} s"
                if self._values.silence(field, t) == math.inf:
                    silence = "yet"
                reason = f"{topic}: nothing came {silence}"
                return ArmHold(lcmt_panda_status.kOther, reason)
        if topics.mode and known[MODE] not in topics.running_modes:
            wanted = " or ".join(map(repr, topics.running_modes))
            reason = f"{topics.mode}: {known[MODE]!r}, not {wanted}"
            return ArmHold(lcmt_panda_status.kOther, reason)
        return ArmHold()
