"""`PageServer`: serves a page's files, and sends its changes."""

import base64
import json
import secrets
import socket
import time
from collections.abc import Mapping
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any
from urllib.request import urlopen

from remosplat_drake.visualization.live_page.newest import Newest
from remosplat_drake.visualization.live_page.web_socket import (
    acceptance,
    is_wanted,
    receive_text,
    send_text,
)

NEWEST = "/newest"
"""Path of the websocket that sends changes to a page."""

KEEP_ALIVE = 0.25
"""The server answers a page after this time even if there is no change [s]."""

_MESHES = "/cas-v1/"
"""Path below which Meshcat's server serves the files of shapes."""

_SETTLE = 0.01
"""Delay of an answer after the first change [s], so that it contains all
changes of the same update."""


class PageServer:
    """A web server in separate threads.

    A page sends, by a websocket, the number of the last change that it has
    drawn. The answer, in JSON, contains the newest values of all items that
    have changed since then, and the number of the latest change. At most one
    answer at a time is on its way to a page.

    Args:
        host: Network interface to listen on; "*" means all.
        port: TCP port; 0 means any free port.
        newest: Store of the values that the page shows.

    Attributes:
        port: The TCP port.
        session: Random name that distinguishes this server from earlier servers
            on the same port.
        is_closed: Whether the server is closed.

    Raises:
        OSError: The port is taken, or there is no such interface.
    """

    def __init__(
        self,
        host: str,
        port: int,
        newest: Newest,
    ):
        self.session = secrets.token_hex(8)
        self.is_closed = False
        self._newest = newest
        self._beat: float | None = None
        self._files: dict[str, tuple[str, bytes]] = {}
        self._meshcat = ""
        self._server = _Server(
            ("" if host == "*" else host, port), partial(_Handler, self)
        )
        self.port: int = self._server.server_address[1]
        Thread(target=self._server.serve_forever, daemon=True).start()

    def serve(
        self, files: Mapping[str, tuple[str, bytes]], meshcat: str
    ) -> None:
        """Sets the files that the server serves.

        Args:
            files: Type and content of each file, keyed by path.
            meshcat: Address of Meshcat's server, which serves the meshes.
        """
        self._files.update(files)
        self._meshcat = meshcat

    def beat(self) -> None:
        """Records that all values are up to date at this moment."""
        self._beat = time.monotonic()

    def rest(self) -> None:
        """Marks the values as final: the page stops showing their age."""
        self._beat = None

    def close(self) -> None:
        """Stops serving, also on open connections."""
        self.is_closed = True
        self._server.shutdown()
        self._server.server_close()

    def file(self, path: str) -> tuple[str, bytes] | None:
        """Returns a file's content type and content; None if there is no file.

        Args:
            path: The file's path.
        """
        if path.startswith(_MESHES) and self._meshcat:
            # Meshcat's files are forwarded, since a browser loads them only
            # from the page's own address.
            with urlopen(self._meshcat + path) as answer:
                return "application/octet-stream", answer.read()
        return self._files.get(path)

    def answer(self, after: int) -> bytes:
        """Returns the changes, in JSON.

        Args:
            after: Number of the last change that the page has drawn.
        """
        asked = time.monotonic()
        version, changes = self._newest.after(after, KEEP_ALIVE)
        if changes and after:
            time.sleep(_SETTLE)
            version, changes = self._newest.after(after)
        now, beat = time.monotonic(), self._beat
        document = {
            "session": self.session,
            "version": version,
            "waited": now - asked,
            "age": 0.0 if beat is None else now - beat,
            "changes": [[*key, _plain(value)] for key, value in changes],
        }
        return json.dumps(document, separators=(",", ":")).encode()


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, address: tuple[str, int], handler):
        if ":" in address[0]:
            self.address_family = socket.AF_INET6
        super().__init__(address, handler)

    def handle_error(self, request, client_address) -> None:
        """Ignores viewers that close the connection during an answer."""


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True

    def __init__(self, page: PageServer, *arguments):
        self._page = page
        super().__init__(*arguments)

    def do_GET(self) -> None:
        """Sends a file, or, on a websocket, changes until it is closed."""
        if self.path == NEWEST:
            self._tell()
            return
        file = self._page.file(self.path)
        if file is None:
            self.send_error(404)
        else:
            self._send(*file)

    def _tell(self) -> None:
        self.close_connection = True
        if not is_wanted(self.headers):
            self.send_error(403)
            return
        key = self.headers.get("Sec-WebSocket-Key", "")
        self.send_response(101)
        self.send_header("Upgrade", "websocket")
        self.send_header("Connection", "Upgrade")
        self.send_header("Sec-WebSocket-Accept", acceptance(key))
        self.end_headers()
        while (drawn := receive_text(self.rfile)) is not None:
            if self._page.is_closed or not drawn.isdigit():
                return
            send_text(self.wfile, self._page.answer(int(drawn)))

    def _send(self, kind: str, content: bytes) -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args) -> None:
        """Prints nothing to the terminal."""


def _plain(value: Any) -> Any:
    """Converts a value to a type of JSON."""
    return base64.b64encode(value).decode() if type(value) is bytes else value
