"""Makes the page's files: Meshcat's viewer with bar, panel and player."""

import json
from functools import cache
from importlib import resources
from pathlib import Path

from pydrake.common import FindResourceOrThrow

_BEGIN, _END = (
    "<!-- CONNECTION BLOCK BEGIN -->",
    "<!-- CONNECTION BLOCK END -->",
)
"""Markers in Meshcat's page that enclose the code for the connection to the
server. A saved page does not have this code."""


def page_files(socket: int, session: str) -> dict[str, tuple[str, bytes]]:
    """Returns the content type and the content of each file of the page.

    Args:
        socket: TCP port of Meshcat's websocket.
        session: Name of the running `PageServer`, which sends the changes.
    """
    script = "text/javascript"
    viewer = _meshcat("html").decode()
    before, _, rest = viewer.partition(_BEGIN)
    given = json.dumps({"socket": socket, "session": session})
    document = with_panel(
        before + rest.partition(_END)[2],
        f"const remosplat = {given};",
        resource("age.js"),
        resource("views.js"),
        resource("live.js"),
    )
    return {
        "/": ("text/html; charset=utf-8", document.encode()),
        "/meshcat.js": (script, _meshcat("js")),
        "/favicon.ico": ("image/x-icon", _meshcat("ico")),
    }


def with_panel(page: str, *scripts: str) -> str:
    """Adds bar, panel and player to a page of Meshcat.

    They are the first elements of the page, so that a person can read them
    while Meshcat's viewer loads.

    Args:
        page: The page.
        *scripts: Scripts that run after the page's own scripts.
    """
    before, body, after = page.partition("<body>")
    head = (
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{resource('page.css')}</style></head>"
    )
    parts = ("panel.js", "task.js", "player.js")
    code = [*map(resource, parts), *scripts]
    tags = "".join(f"<script>{text}</script>" for text in code)
    before = before.replace("</head>", head)
    return f"{before}{body}{resource('body.html')}{tags}{after}"


@cache
def resource(name: str) -> str:
    """Returns the text of a file in `web/`.

    Args:
        name: The file's name.
    """
    folder = resources.files("remosplat_drake.visualization") / "web"
    return folder.joinpath(name).read_text("utf-8")


@cache
def _meshcat(kind: str) -> bytes:
    path = FindResourceOrThrow(f"drake/geometry/meshcat.{kind}")
    return Path(path).read_bytes()
