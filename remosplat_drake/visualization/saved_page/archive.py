"""`pack`: an HTML page that carries itself compressed."""

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
# They name files of the computer that the page was made on.
_SOURCE = re.compile(r"^// .* from /.*\n", re.MULTILINE)
_STRIDES = (1, 2, 4, 9)
"""Sizes of elements: bytes, shorts, floats, and doubles of msgpack, each with a
byte for its type before it."""


def pack(page: str, title: str) -> str:
    """Compresses a page of Meshcat into one that inflates itself.

    What Meshcat has written as text is kept as bytes, and numbers byte by
    byte: all of their first bytes, then all of their second ones. Such groups
    compress better. Meshcat's commands run one after the other.

    Args:
        page: The page, as `Meshcat.StaticHtml` has made it, or more.
        title: Title of the page while it is opening.
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
        Bytes that inflate to the length of an index, the index in JSON with
        size and stride of each part, and the parts.
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
    """Sorts bytes by their index in groups of `stride`; a rest stays last."""
    end = len(data) // stride * stride
    places = [data[k:end:stride] for k in range(stride)]
    return b"".join([*places, data[end:]])
