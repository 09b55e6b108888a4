"""A headless Chromium that looks at a page, clicks and types.

It is driven over a pair of pipes (the DevTools protocol: one JSON message a
NUL byte), so that nothing needs to be installed besides the browser.
"""

import base64
import itertools
import json
import os
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from patience import PATIENCE
from screenshot import FLAGS, find_chromium

_STEPS = 5
"""Of a mouse that drags something."""


class Chromium:
    """The program, and the pipes to it."""

    def __init__(self):
        chromium = find_chromium()
        assert chromium is not None
        from_us, self._write = os.pipe()
        self._read, to_us = os.pipe()
        self._numbers = itertools.count(1)
        self._buffer = b""

        def arrange():
            # Chromium reads descriptor 3 and writes descriptor 4.
            ours = os.dup(from_us), os.dup(to_us)
            os.dup2(ours[0], 3)
            os.dup2(ours[1], 4)

        self._profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self._process = subprocess.Popen(
            [
                chromium,
                *FLAGS,
                f"--user-data-dir={self._profile.name}",
                "--remote-debugging-pipe",
            ],
            close_fds=False,
            preexec_fn=arrange,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(from_us)
        os.close(to_us)

    def end(self):
        """Ends the program."""
        self._process.kill()
        self._process.wait()
        os.close(self._write)
        os.close(self._read)
        self._profile.cleanup()

    def ask(self, method: str, session: str = "", **parameters) -> dict:
        """Sends a command, and returns its result.

        Args:
            method: Name of the command in the DevTools protocol.
            session: The tab that it is for; empty for the browser.
            parameters: The command's parameters.
        """
        number = next(self._numbers)
        message = {"id": number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = json.loads(self._receive())
            if answer.get("id") == number:
                assert "error" not in answer, answer
                return answer["result"]

    def _receive(self) -> bytes:
        while b"\0" not in self._buffer:
            chunk = os.read(self._read, 1 << 16)
            assert chunk, "the browser has gone"
            self._buffer += chunk
        message, _, self._buffer = self._buffer.partition(b"\0")
        return message


class Browser:
    """One tab; made by `open_browser`."""

    def __init__(self, program: Chromium, size: tuple[int, int]):
        self._program = program
        # A tab in a window of its own is in front, so that it is drawn.
        target = program.ask(
            "Target.createTarget",
            url="about:blank",
            browserContextId=program.ask("Target.createBrowserContext")[
                "browserContextId"
            ],
            newWindow=True,
        )
        attached = program.ask(
            "Target.attachToTarget", targetId=target["targetId"], flatten=True
        )
        self._session = attached["sessionId"]
        # Keys reach a window that lies behind another one, too.
        self._ask("Emulation.setFocusEmulationEnabled", enabled=True)
        self.show_as(*size)

    def open(self, url: str):
        """Loads a page."""
        self._ask("Page.navigate", url=url)

    def run_first(self, script: str):
        """Runs a script in every page from now on, before its own ones."""
        self._ask("Page.enable")
        self._ask("Page.addScriptToEvaluateOnNewDocument", source=script)

    def draw_nothing(self):
        """Lets Meshcat pages leave out their 3D pictures from now on.

        In software a picture takes so long that a page would fall behind what
        a moving robot tells it, lose its connection, and load itself again.
        """
        self.run_first(
            "addEventListener('DOMContentLoaded',"
            " () => { if (window.viewer) viewer.render = () => {}; })"
        )

    def show_as(
        self,
        width: int,
        height: int,
        *,
        mobile: bool = False,
        scale: float = 1.0,
    ):
        """Gives the page another size, or that of a telephone.

        Args:
            width: Width of the window [px].
            height: Its height [px].
            mobile: Whether it is a telephone's.
            scale: Pixels of the screen for a pixel of the page.
        """
        self._ask(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=scale,
            mobile=mobile,
        )

    def listen_to_console(self):
        """Keeps what goes wrong in pages from now on, for `console`."""
        self.run_first(
            "if (!window.wrong) { window.wrong = [];"
            " addEventListener('error', (e) => wrong.push(e.message));"
            " addEventListener('unhandledrejection',"
            " (e) => wrong.push(String(e.reason)));"
            " console.error = (...said) =>"
            "   wrong.push(said.map(s => s?.type ?? s).join(' ')); }"
        )

    def console(self) -> list[str]:
        """What has gone wrong in the page since it was opened."""
        return self.evaluate("window.wrong")

    def evaluate(self, expression: str) -> Any:
        """The value of a JavaScript expression in the page."""
        answer = self._ask(
            "Runtime.evaluate", expression=expression, returnByValue=True
        )
        return answer["result"].get("value")

    def wait_for(self, expression: str) -> Any:
        """Waits until an expression is true, and returns its value."""
        end = time.monotonic() + PATIENCE
        while not (value := self.evaluate(expression)):
            if time.monotonic() > end:
                text = self.evaluate("document.body.innerText")
                raise AssertionError(f"never true: {expression} in\n{text}")
            time.sleep(0.02)
        return value

    def click(self, selector: str, at: float = 0.5, text: str = ""):
        """Clicks with the mouse into an element.

        Args:
            selector: Of the first such element.
            at: Where between its left and its right end.
            text: What its row of the page must hold.
        """
        place = self._place(selector, at, text)
        self._mouse("mousePressed", place)
        self._mouse("mouseReleased", place)

    def drag(self, selector: str, ends: tuple[float, float], text: str = ""):
        """Drags with the mouse along an element.

        Args:
            selector: Of the first such element.
            ends: From where to where between its left and its right end.
            text: What its row of the page must hold.
        """
        here, there = (self._place(selector, at, text) for at in ends)
        self._mouse("mousePressed", here)
        for k in range(1, _STEPS + 1):
            share = k / _STEPS
            x, y = (
                a + share * (b - a) for a, b in zip(here, there, strict=True)
            )
            self._mouse("mouseMoved", [x, y])
        self._mouse("mouseReleased", there)

    def _place(self, selector: str, at: float, text: str) -> list[float]:
        """Where to point at, from the page's upper left corner [px]."""
        return self.wait_for(
            f"(() => {{ const e = [...document.querySelectorAll("
            f"{json.dumps(selector)})].find(e => (e.closest('li') || e)"
            f".innerText.includes({json.dumps(text)})); if (!e) return null;"
            "const r = e.getBoundingClientRect(); if (!r.width) return null;"
            f"return [r.x + {at} * r.width, r.y + r.height / 2]; }})()"
        )

    def _mouse(self, kind: str, place: list[float]):
        x, y = place
        self._ask(
            "Input.dispatchMouseEvent",
            type=kind,
            x=x,
            y=y,
            button="left",
            buttons=0 if kind == "mouseReleased" else 1,
            clickCount=1,
        )

    def press(self, key: str):
        """Presses and lets go of a key whose name is its code."""
        for kind in ("keyDown", "keyUp"):
            self._ask("Input.dispatchKeyEvent", type=kind, key=key, code=key)

    def picture(self) -> bytes:
        """Returns a picture of the page, as a PNG."""
        answer = self._ask("Page.captureScreenshot", format="png")
        return base64.b64decode(answer["data"])

    def save_picture(self, path: Path):
        """Writes what the page looks like as a PNG."""
        path.write_bytes(self.picture())

    def _ask(self, method: str, **parameters) -> dict[str, Any]:
        return self._program.ask(method, self._session, **parameters)


@contextmanager
def open_browser(size: tuple[int, int] = (1200, 800)) -> Iterator[Browser]:
    """Opens a browser with one tab, and ends it with the block.

    Each block has a browser of its own, since pages that draw in software
    starve those that other tests open in the same one.
    """
    program = Chromium()
    try:
        yield Browser(program, size)
    finally:
        program.end()
