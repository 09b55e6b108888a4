"""Visitors and their updates, over a socket as a browser has it."""

import json
import socket
import urllib.error
import urllib.request

import pytest

from remosplat_drake.visualization.live_page.newest import Newest
from remosplat_drake.visualization.live_page.page_server import PageServer
from remosplat_drake.visualization.live_page.web_socket import acceptance

KEY, ACCEPTED = "dGhlIHNhbXBsZSBub25jZQ==", "s3pPLMBiTxaQ9kYGzzhZRbK+xOo="
"""The example of RFC 6455, section 1.3."""


class Onlooker:
    """A browser's end of the websocket."""

    def __init__(self, port: int, origin: str):
        self._socket = socket.create_connection(("localhost", port))
        self._file = self._socket.makefile("rwb")
        lines = (
            "GET /newest HTTP/1.1",
            f"Host: localhost:{port}",
            f"Origin: {origin}",
            "Upgrade: websocket",
            "Connection: Upgrade",
            f"Sec-WebSocket-Key: {KEY}",
            "",
            "",
        )
        self._file.write("\r\n".join(lines).encode())
        self._file.flush()
        self.head = b""
        while not self.head.endswith(b"\r\n\r\n"):
            self.head += self._file.readline()

    def ask(self, drawn: int) -> dict:
        """Says what it has drawn, and waits for what is new."""
        mask, text = b"abcd", str(drawn).encode()
        data = bytes(b ^ mask[i % 4] for i, b in enumerate(text))
        self._file.write(bytes([0x81, 0x80 | len(text)]) + mask + data)
        self._file.flush()
        kind, size = self._file.read(2)
        assert kind == 0x81
        if size > 125:
            size = int.from_bytes(self._file.read(2 if size == 126 else 8))
        return json.loads(self._file.read(size))


@pytest.fixture
def newest() -> Newest:
    return Newest()


@pytest.fixture
def server(newest):
    server = PageServer("localhost", 0, newest)
    yield server
    server.close()


def test_the_answer_to_a_key_is_that_of_the_standard():
    assert acceptance(KEY) == ACCEPTED


@pytest.mark.parametrize("length", [1, 200, 70_000])
def test_an_onlooker_gets_what_it_has_not_drawn(server, newest, length):
    onlooker = Onlooker(server.port, f"http://localhost:{server.port}")
    assert b"101" in onlooker.head and ACCEPTED.encode() in onlooker.head
    newest.put(("bar",), length * "a")
    newest.put(("pose", "/hand"), b"\x00\x01")
    answer = onlooker.ask(0)
    assert answer["changes"] == [
        ["bar", length * "a"],
        ["pose", "/hand", "AAE="],
    ]
    assert answer["session"] == server.session and answer["age"] == 0.0
    again = onlooker.ask(answer["version"])
    assert again["changes"] == [] and again["version"] == answer["version"]


def test_the_age_is_that_of_the_latest_beat(server):
    onlooker = Onlooker(server.port, f"http://localhost:{server.port}")
    server.beat()
    first, second = onlooker.ask(0), onlooker.ask(0)
    assert 0.0 < first["age"] < second["age"]
    server.rest()
    assert onlooker.ask(0)["age"] == 0.0


def test_a_page_from_elsewhere_is_told_nothing(server):
    assert b"403" in Onlooker(server.port, "http://evil.example").head


def test_a_file_that_is_not_there_is_missed(server):
    server.serve({"/": ("text/html", b"<p>page</p>")}, "")
    url = f"http://localhost:{server.port}"
    with urllib.request.urlopen(url) as answer:
        assert answer.read() == b"<p>page</p>"
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(f"{url}/etc/passwd")
