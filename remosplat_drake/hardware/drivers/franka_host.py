"""What connecting to a Franka controller can run into."""

import socket

from remosplat_drake.base.errors import RemoSplatError

_ARM_PORT, _HAND_PORT = 1337, 1338
_PATIENCE = 3.0


def check_reachable(host: str, hand: bool = False) -> None:
    """Libfranka alone would wait for minutes for a host that is not there.

    Args:
        host: Name or address of the arm's controller.
        hand: Whether the hand is wanted, which has a port of its own.

    Raises:
        RemoSplatError: Nobody answers.
    """
    port = _HAND_PORT if hand else _ARM_PORT
    try:
        socket.create_connection((host, port), _PATIENCE).close()
    except OSError as error:
        raise RemoSplatError(
            f"no Panda answers at {host}, port {port}:"
            f" {error.strerror or error}; is FCI active in Desk?"
        ) from error


def one_line(error: Exception) -> str:
    """What an error of libfranka says, without its line breaks."""
    return " ".join(str(error).split())
