"""`pack`: turns an HTML page into a compressed page that unpacks itself."""

import base64
import html
import json
import re
import struct
import zlib
from collections.abc import Sequence

from remosplat_drake.visualization.live_page.page_files import resource

_ASSET = re.compile(r'"data:application/octet-[a-z]+;base64,([A-Za-z0-9+/=]*)"')
_COMMAND = re.compile(
    r"fetch\(" + _ASSET.pattern + r"\)"
    r"\s*\.then\(res => res\.arrayBuffer\(\)\)"
    r"\s*\.then\(buffer =>"
    r" viewer\.handle_command_bytearray\(new Uint8Array\(buffer\)\)\);"
)
# These comments of the page contain paths of the computer that made it, so they
# are removed.
_SOURCE = re.compile(r"^// .* from /.*\n", re.MULTILINE)
_STRIDES = (1, 2, 4, 9)
"""Sizes of the elements of arrays [bytes]: 1 for bytes, 2 for shorts, 4 for
floats, and 9 for doubles in msgpack (a type byte and 8 bytes)."""


def pack(page: str, title: str) -> str:
    """Compresses a page of Meshcat into one that unpacks itself.

    Data that Meshcat encodes as text are stored as bytes. Arrays of numbers are
    stored as the first bytes of all elements, then their second bytes, and so
    on, since this order compresses better. The unpacked page executes Meshcat's
    commands in order.

    Args:
        page: The page from `Meshcat.StaticHtml`; it may contain additions.
        title: Title of the page while it is unpacked.
    """
    parts = [b""]

    def keep(data: str) -> int:
        parts.append(base64.b64decode(data))
        return len(parts) - 1

    page = _COMMAND.sub(
        lambda m: (
            f"viewer.handle_command_bytearray(remosplat.part({keep(m[1])}));"
        ),
        page,
    )
    page = _ASSET.sub(lambda m: f"remosplat.url({keep(m[1])})", page)
    parts[0] = _SOURCE.sub("", page).encode()
    packed = base64.b64encode(compressed(parts)).decode()
    script = resource("unpack.js")
    return (
        '<!DOCTYPE html><html lang="en"><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{html.escape(title)}</title><p id="wait">Opening …</p>'
        f'<script id="packed" type="text/plain">{packed}</script>'
        f"<script>{script}</script></html>\n"
    )


def compressed(parts: Sequence[bytes]) -> bytes:
    """Compresses several parts, as `unpack.js` reads them.

    Args:
        parts: The parts.

    Returns:
        Compressed bytes. Their content is the length of an index, the index in
        JSON with the size and stride of each part, and the parts.
    """
    index, spread = [], []
    for part in parts:
        stride, data = min(
            ((k, _by_place(part, k)) for k in _STRIDES),
            key=lambda item: len(zlib.compress(item[1], 1)),
        )
        index.append([len(part), stride])
        spread.append(data)
    head = json.dumps(index).encode()
    return zlib.compress(
        b"".join([struct.pack("<I", len(head)), head, *spread]), 9
    )


def _by_place(data: bytes, stride: int) -> bytes:
    """Reorders bytes: byte 0 of each group of `stride` bytes, then byte 1, etc.

    An incomplete last group stays at the end.
    """
    end = len(data) // stride * stride
    places = [data[k:end:stride] for k in range(stride)]
    return b"".join([*places, data[end:]])
