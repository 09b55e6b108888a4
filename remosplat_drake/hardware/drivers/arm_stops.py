"""`ArmStops`: whether topics beside its joint states let an arm move."""

import dataclasses as dc
from typing import NamedTuple

from drake import lcmt_panda_status

from remosplat_drake.hardware.drivers.topic_values import TopicValues

STRING, INT32, BOOL = "String", "Int32", "Bool"

MODE_TYPES = (STRING, INT32, BOOL)
"""Messages of std_msgs that may tell an arm's mode."""

EMERGENCY_STOP, MODE = "emergency_stop", "mode"


@dc.dataclass(frozen=True)
class ArmTopics:
    """The topics of an arm; an empty name stands for none.

    Attributes:
        command: Topic of the std_msgs/Float64MultiArray commands.
        states: Topic of the sensor_msgs/JointState measurements.
        emergency_stop: Topic of std_msgs/Bool: whether one is latched.
        mode: Topic that says in which mode the arm is.
        mode_type: Its messages, one of `MODE_TYPES`.
        running_modes: What it says while the arm obeys, as text: `true` for a
            Bool, `7` for an Int32.
        stop_expiry: Age from which on the last two topics say nothing any more
            [s].
    """

    command: str = "/velocity_controller/commands"
    states: str = "/joint_states"
    emergency_stop: str = ""
    mode: str = ""
    mode_type: str = STRING
    running_modes: tuple[str, ...] = ()
    stop_expiry: float = 2.0

    @property
    def stops(self) -> dict[str, str]:
        """The topics that say whether the arm may move, by their fields."""
        topics = {EMERGENCY_STOP: self.emergency_stop, MODE: self.mode}
        return {field: topic for field, topic in topics.items() if topic}


class ArmHold(NamedTuple):
    """Whether something holds an arm.

    Attributes:
        mode: The arm's mode, a value of lcmt_panda_status.robot_mode.
        reason: Why the arm must not move; empty if it may.
    """

    mode: int = lcmt_panda_status.kMove
    reason: str = ""


class ArmStops:
    """The latest values of topics that say whether an arm may move."""

    def __init__(self, topics: ArmTopics):
        """Starts without values: an arm whose topics are silent is held."""
        self._topics = topics
        self._values = TopicValues[str](topics.stop_expiry)

    def put(self, field: str, value: bool | int | str, t: float) -> None:
        """Keeps a value that came at a time t, by a clock that never jumps [s].

        Args:
            field: `EMERGENCY_STOP` or `MODE`.
            value: What its topic says.
            t: When it came [s].
        """
        text = str(value)
        self._values.put(
            field, text.lower() if isinstance(value, bool) else text, t
        )

    def hold(self, t: float) -> ArmHold:
        """Returns what the topics say at a time t [s]."""
        topics, known = self._topics, self._values.known(t)
        if known.get(EMERGENCY_STOP) == "true":
            reason = f"{topics.emergency_stop}: emergency stop"
            return ArmHold(lcmt_panda_status.kUserStopped, reason)
        for field, topic in topics.stops.items():
            if field not in known:
                silence = f"for more than {topics.stop_expiry:g} s"
                if self._values.silence(field, t) == float("inf"):
                    silence = "yet"
                reason = f"{topic}: nothing came {silence}"
                return ArmHold(lcmt_panda_status.kOther, reason)
        if topics.mode and known[MODE] not in topics.running_modes:
            wanted = " or ".join(map(repr, topics.running_modes))
            reason = f"{topics.mode}: {known[MODE]!r}, not {wanted}"
            return ArmHold(lcmt_panda_status.kOther, reason)
        return ArmHold()
