"""Checks the connection to a Franka controller, and formats its errors."""

import socket

from remosplat_drake.base.errors import RemoSplatError

_ARM_PORT, _HAND_PORT = 1337, 1338
_PATIENCE = 3.0


def check_reachable(host: str, hand: bool = False) -> None:
    """Checks that a Franka controller answers.

    Without this check, libfranka would wait for minutes for a missing host.

    Args:
        host: Name or address of the arm's controller.
        hand: Whether the hand's TCP port is checked, in place of the arm's.

    Raises:
        RemoSplatError: No answer comes within three seconds.
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
    """Formats an error of libfranka without line breaks."""
    return " ".join(str(error).split())
