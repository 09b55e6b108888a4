"""Opens and closes the hand by an operator's requests."""

import dataclasses as dc

from remosplat_drake.signals.operator_command import OperatorCommand


@dc.dataclass(frozen=True)
class HandLaw:
    """The two commands that an operator gives to a hand.

    Attributes:
        width: Opening of the open hand [m]. The hand has this opening at the
            start and in the collision geometry.
        force: Force with which the hand closes [N].
    """

    width: float
    force: float

    def command(self, *, is_open: bool) -> tuple[float, float]:
        """Returns the commanded width and force [m, N].

        Args:
            is_open: Whether the hand shall be open; otherwise it closes until
                it touches an object.
        """
        return (self.width if is_open else 0.0), self.force


def advance_hand(
    known: OperatorCommand, command: OperatorCommand, *, is_open: bool
) -> bool:
    """Returns whether the hand shall be open, after new requests.

    If both buttons were pressed, the hand closes, so that it does not drop an
    object.

    Args:
        known: The requests at the previous call.
        command: The requests now.
        is_open: Result of the previous call.
    """
    if command.closes > known.closes:
        return False
    return is_open or command.opens > known.opens
