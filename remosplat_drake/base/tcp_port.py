"""Checks whether a page can be served on a TCP port."""

import errno
import socket

from remosplat_drake.base.errors import RemoSplatError


def is_free(host: str, port: int) -> bool:
    """Returns whether a TCP port is free.

    Args:
        host: Network interface, in the format of `--host`; "*" means all.
        port: The TCP port; 0 means any.

    Raises:
        RemoSplatError: There is no such interface, or listening there is not
            permitted.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    address = "" if host == "*" else host
    try:
        with socket.create_server((address, port), family=family):
            return True
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            return False
        why = error.strerror
        raise RemoSplatError(f"--host {host}: {why}") from error


def check_free(host: str, port: int | None) -> None:
    """Raises an error if no page can be served at an address.

    If a command serves a page only after a long computation, it calls this
    function before the computation.

    Args:
        host: Network interface, in the format of `--host`.
        port: The TCP port, in the format of `--port`; None for the first free
            port.

    Raises:
        RemoSplatError: There is no such interface, or the port is taken.
    """
    if not is_free(host, port or 0):
        raise RemoSplatError(
            f"--port {port} is taken on {host}: choose another one, or leave"
            " the flag out for the first free one"
        )
