"""The web server of the cockpit's page."""

import io
from contextlib import redirect_stdout

import viser
from viser._messages import ShareUrlDisconnect, ShareUrlRequest

from remosplat_drake.base.tcp_port import check_free, is_free
from remosplat_drake.cockpit.messages import CockpitJob

_FIRST_PORT = 8080
"""The port that is tried first."""


def open_server(job: CockpitJob) -> viser.ViserServer:
    """Opens the page's server, and suppresses viser's messages.

    Args:
        job: The settings of the cockpit, with the page's address and title.

    Raises:
        RemoSplatError: The port is taken, or there is no such interface.
    """
    with redirect_stdout(io.StringIO()):
        server = viser.ViserServer(
            host=job.host,
            port=_free_port(job.host, job.port),
            label=job.title,
            verbose=False,
        )
    _offer_no_tunnel(server)
    return server


def _free_port(host: str, port: int | None) -> int:
    """Returns the requested port, or the first free one if None is requested.

    Raises:
        RemoSplatError: The requested port is taken, or there is no such
            interface.
    """
    if port is None:
        candidates = range(_FIRST_PORT, 65536)
        return next(p for p in candidates if is_free(host, p))
    check_free(host, port)
    return port


def _offer_no_tunnel(server: viser.ViserServer) -> None:
    """Prevents browsers from opening viser's tunnel to the internet."""
    connection = server._websock_server
    for message in (ShareUrlRequest, ShareUrlDisconnect):
        connection.unregister_handler(message)
