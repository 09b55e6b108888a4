"""The packets between `fci_library` and `FciArm`.

Their format is not Franka's, but their content is the same: a state has a
number, and a command has the number of the state that it answers.
"""

import dataclasses as dc
import struct
from enum import IntEnum

LARGEST = 1024
"""Greatest length of a packet [bytes]."""

_STATE = struct.Struct("=qqd57s56d")
_REQUEST = struct.Struct("=qq13d")


class Kind(IntEnum):
    """Requests of a client to the robot."""

    READ = 0
    """Requests a state."""
    BEGIN = 1
    """Starts a motion: the robot then sends a state every millisecond, and the
    client must answer each state."""
    COMMAND = 2
    """Answers a state with seven joint rates."""
    LAST = 3
    """Answers a state, and ends the motion."""
    COLLISION = 4
    """Sets the collision limits, seven torques and six forces; the robot
    answers with a state."""


@dc.dataclass(frozen=True)
class Request:
    """A message of a client.

    Attributes:
        kind: The kind of request.
        number: Number of the state that the request answers; 0 if it answers
            none.
        values: Thirteen numbers, padded with zeros.
    """

    kind: Kind
    number: int = 0
    values: tuple[float, ...] = ()

    def encode(self) -> bytes:
        """Packs the request."""
        padding = (0.0,) * (13 - len(self.values))
        return _REQUEST.pack(self.kind, self.number, *self.values, *padding)

    @staticmethod
    def decode(data: bytes) -> "Request":
        """Unpacks a request.

        Raises:
            ValueError: The packet is not a request.
        """
        try:
            kind, number, *values = _REQUEST.unpack(data)
        except struct.error as error:
            raise ValueError("no request") from error
        return Request(Kind(kind), number, tuple(values))


@dc.dataclass(frozen=True)
class State:
    """A message of the robot.

    Attributes:
        number: Number of the robot's control cycle; a cycle lasts 1 ms.
        mode: The arm's mode, as libfranka numbers it.
        success_rate: Fraction of the latest 100 packets that arrived.
        error: Reason why the latest motion was aborted; empty if it was not.
        vectors: q, q_d, dq, dq_d, ddq_d, tau_J, tau_J_d and
            tau_ext_hat_filtered, seven numbers each.
    """

    number: int
    mode: int
    success_rate: float
    error: str
    vectors: tuple[float, ...]

    def encode(self) -> bytes:
        """Packs the state."""
        text = self.error.encode()
        return _STATE.pack(
            self.number, self.mode, self.success_rate, text, *self.vectors
        )

    @staticmethod
    def decode(data: bytes) -> "State":
        """Unpacks a state.

        Raises:
            ValueError: The packet is not a state.
        """
        try:
            number, mode, rate, text, *vectors = _STATE.unpack(data)
        except struct.error as error:
            raise ValueError("no state") from error
        error = text.rstrip(b"\0").decode()
        return State(number, mode, rate, error, tuple(vectors))
