"""`watch`: a client of a run's page that draws two pictures a second.

It stands for a browser without a GPU, but takes no time of the processor, so
that ticks are compared and not the load of the machine.
"""

import json
import time
from contextlib import suppress

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

FRAME = 0.5
"""Time between two pictures [s]."""


def watch(page: int, meshcat: int, frame: float = FRAME) -> None:
    """Watches a page until its servers close the connections.

    As a browser does, it requests the newest state after each picture, and
    receives the shapes that Meshcat has sent meanwhile.

    Args:
        page: Port of the page's server.
        meshcat: Port of Meshcat's server.
        frame: Time between two pictures [s].
    """
    origin = f"http://localhost:{page}"
    with (
        connect(f"ws://localhost:{page}/newest", origin=origin) as news,
        connect(f"ws://localhost:{meshcat}", max_size=None) as shapes,
    ):
        version = 0
        with suppress(ConnectionClosed):
            while True:
                news.send(str(version))
                version = json.loads(news.recv())["version"]
                _receive_all(shapes)
                time.sleep(frame)


def _receive_all(shapes: ClientConnection) -> None:
    """Receives what has arrived."""
    while True:
        try:
            shapes.recv(timeout=0)
        except TimeoutError:
            return
