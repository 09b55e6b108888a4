"""Whether a page can be served where its flags say."""

import errno
import socket

from remosplat_drake.base.errors import RemoSplatError


def is_free(host: str, port: int) -> bool:
    """Tells whether nobody else listens at a port.

    Args:
        host: Network interface, as `--host` has it; "*" stands for all.
        port: The TCP port; 0 stands for any.

    Raises:
        RemoSplatError: There is no such interface, or nobody may listen there.
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
    """Refuses a place where no page could be served.

    A page that is served late tells so at once, before anything is done.

    Args:
        host: Network interface, as `--host` has it.
        port: The TCP port, as `--port` has it; None for the first free one.

    Raises:
        RemoSplatError: There is no such interface, or the port is taken.
    """
    if not is_free(host, port or 0):
        raise RemoSplatError(
            f"--port {port} is taken on {host}: choose another one, or leave"
            " the flag out for the first free one"
        )
