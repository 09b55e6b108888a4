"""`LiveServer`: publishes a recording's messages over Foxglove's websocket.

Foxglove connects to `ws://HOST:PORT` and shows the messages immediately. The
server does not wait for a slow client, which loses messages.
"""

import json

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.recording.mcap.messages import Message
from remosplat_drake.recording.mcap.schemas import SCHEMAS

HOST = "127.0.0.1"
"""Address of the server; only this computer can reach it. For access from other
computers, use an SSH tunnel."""


class LiveServer:
    """Publishes messages to all clients, on the channels of the file."""

    def __init__(self, port: int):
        """Starts the server.

        Args:
            port: TCP port of this computer; 0 selects a free port.

        Raises:
            MissingExtraError: The package `foxglove-sdk` is not installed.
            RemoSplatError: The port is not available.
        """
        self._foxglove = import_optional("foxglove", "--live", "live")
        self._context = self._foxglove.Context()
        self._channels: dict = {}
        try:
            self._server = self._foxglove.start_server(
                name="remosplat", host=HOST, port=port, context=self._context
            )
        except (RuntimeError, OSError) as error:
            raise RemoSplatError(f"--live: port {port}: {error}") from error

    @property
    def port(self) -> int:
        """TCP port at which the server listens."""
        return self._server.port

    def add(self, message: Message) -> None:
        """Publishes a message."""
        if message.topic not in self._channels:
            schema = self._foxglove.Schema(
                name=message.schema,
                encoding="jsonschema",
                data=json.dumps(SCHEMAS[message.schema]).encode(),
            )
            self._channels[message.topic] = self._foxglove.Channel(
                message.topic,
                schema=schema,
                message_encoding="json",
                context=self._context,
            )
        data = json.dumps(message.content, allow_nan=False).encode()
        self._channels[message.topic].log(data, log_time=message.nanoseconds)

    def close(self) -> None:
        """Ends the connections."""
        self._server.stop()
