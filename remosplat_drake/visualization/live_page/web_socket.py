"""The part of a websocket server that the page needs (RFC 6455)."""

import base64
import hashlib
from email.message import Message
from io import BufferedIOBase

_GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
"""Text that is appended to a client's key (RFC 6455, section 1.3)."""

_TEXT, _CLOSE = 0x1, 0x8
_LAST, _MASKED = 0x80, 0x80
_SHORT = 125
"""The second byte of a frame can state message lengths up to this [bytes]."""


def is_wanted(headers: Message) -> bool:
    """Returns whether a page of this server requests a websocket.

    Requests from pages of other servers are rejected. A browser lets every page
    open a websocket, and states the page's origin in the request. Without this
    check, any page could read the messages.

    Args:
        headers: The headers of the request.
    """
    origin, host = headers.get("Origin", ""), headers.get("Host")
    is_asked = headers.get("Upgrade", "").lower() == "websocket"
    return is_asked and origin.partition("://")[2] == host


def acceptance(key: str) -> str:
    """Returns the answer to a client's key.

    Args:
        key: The header Sec-WebSocket-Key.
    """
    digest = hashlib.sha1(key.encode() + _GUID).digest()
    return base64.b64encode(digest).decode()


def send_text(file: BufferedIOBase, text: bytes) -> None:
    """Sends a text as one frame.

    Args:
        file: The connection.
        text: The text in UTF-8.
    """
    size = len(text)
    if size <= _SHORT:
        head = bytes([size])
    elif size < 1 << 16:
        head = bytes([126]) + size.to_bytes(2, "big")
    else:
        head = bytes([127]) + size.to_bytes(8, "big")
    file.write(bytes([_LAST | _TEXT]) + head + text)
    file.flush()


def receive_text(file: BufferedIOBase) -> bytes | None:
    """Waits for a short text, and returns it; None if the connection ends.

    Args:
        file: The connection.
    """
    while True:
        head = file.read(2)
        if len(head) < 2:
            return None
        kind, size = head[0] & 0x0F, head[1] & ~_MASKED
        # Clients must mask all frames, and the page sends only short frames.
        if not head[1] & _MASKED or size > _SHORT or kind == _CLOSE:
            return None
        mask, data = file.read(4), file.read(size)
        if len(data) < size:
            return None
        if kind == _TEXT:
            return bytes(b ^ mask[i % 4] for i, b in enumerate(data))
