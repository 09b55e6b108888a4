"""A browser's tab that shows a cockpit, and a person before it."""

import json
from collections.abc import Iterator
from contextlib import contextmanager

from browser import Browser, open_browser

_BUTTONS = (
    "[...document.querySelectorAll('button')]"
    ".filter(b => b.getClientRects().length)"
)
_FIELDS = (
    "[...document.querySelectorAll('input')]"
    ".filter(e => e.type == 'text' && e.getClientRects().length)"
)
OF_VISER = (
    "THREE.BufferGeometry.computeBoundingSphere(): Computed radius is NaN. The"
    ' "position" attribute is likely to have NaN values.'
    " InstancedBufferGeometry"
)
"""What three.js says of viser's splats, and of nothing else that is drawn.

The corners of the square that stands for a Gaussian have x and y only, and
three.js looks for their z, before it draws them all the same.
"""

DRAW_NOTHING = """
const gl = WebGL2RenderingContext.prototype;
for (const name of Object.getOwnPropertyNames(gl)) {
  if (!/^(clear$|draw(?!ingBuffer))/.test(name)) continue;
  const work = gl[name];
  gl[name] = function (...a) { if (window.draws) work.apply(this, a); };
}
"""
"""In software a picture takes longer than that at which its age is said. The
scene is drawn only while `draws` is set."""


class CockpitTab:
    """One client of a cockpit."""

    def __init__(self, tab: Browser, url: str):
        self.tab = tab
        tab.listen_to_console()
        tab.open(url)
        self.wait_for_button("STOP")

    @property
    def buttons(self) -> list[str]:
        """The labels of all buttons in sight."""
        return self.tab.evaluate(f"{_BUTTONS}.map(b => b.innerText)")

    def wait_for_button(self, label: str):
        """Waits until there is a button."""
        self.tab.wait_for(
            f"{_BUTTONS}.some(b => b.innerText == {json.dumps(label)})"
        )

    def wait_without_button(self, label: str):
        """Waits until there is no such button."""
        self.tab.wait_for(
            f"!{_BUTTONS}.some(b => b.innerText == {json.dumps(label)})"
        )

    def press(self, label: str):
        """Clicks at a button."""
        self.wait_for_button(label)
        self.tab.evaluate(
            f"{_BUTTONS}.find(b => b.innerText == {json.dumps(label)}).click()"
        )

    def press_any(self, *labels: str) -> str:
        """Clicks at the first button of several that is in sight.

        Returns:
            The label of that button; empty if there is none.
        """
        for label in labels:
            if self.tab.evaluate(
                f"(b => (b?.click(), !!b))({_BUTTONS}"
                f".find(b => b.innerText == {json.dumps(label)}))"
            ):
                return label
        return ""

    def unfold(self, label: str):
        """Clicks at the title of a folder."""
        titles = "[...document.querySelectorAll('div')].filter(d =>"
        self.tab.evaluate(
            f"{titles} d.innerText == {json.dumps(label)}).at(-1).click()"
        )

    def scroll_to_the_end(self):
        """Scrolls the panel as far down as it goes."""
        self.tab.evaluate(
            "document.querySelectorAll('.mantine-ScrollArea-viewport')"
            ".forEach(v => { v.scrollTop = 1e6; })"
        )

    def wait_for_stop_in_sight(self, size: tuple[int, int]):
        """Waits until STOP is whole in a window, large, and not covered."""
        self.tab.wait_for(
            f"(() => {{ const b = {_BUTTONS}.find(b => b.innerText == 'STOP');"
            "if (!b) return false;"
            "const r = b.getBoundingClientRect();"
            "const at = (x, y) => b.contains(document.elementFromPoint("
            "  r.x + x * r.width, r.y + y * r.height));"
            "return r.height > 39 && r.width > 100 && r.x >= 0 && r.y >= 0"
            f"  && r.right <= {size[0]} && r.bottom <= {size[1]}"
            "  && at(0.1, 0.1) && at(0.5, 0.5) && at(0.9, 0.9); })()"
        )

    def key(self, code: str, key: str):
        """Presses a key."""
        for kind in ("keyDown", "keyUp"):
            self.tab._ask(
                "Input.dispatchKeyEvent", type=kind, key=key, code=code
            )

    def type_code(self, code: str):
        """Types a code into its field."""
        self.wait_for_button("Operate")
        self.tab.wait_for(f"{_FIELDS}.length > 0")
        self.tab.evaluate(f"{_FIELDS}.at(-1).select()")
        self.tab._ask("Input.insertText", text=code)

    def operate(self, code: str):
        """Becomes the operator."""
        self.type_code(code)
        self.wait_for_button("Hold")
        # Keys have no effect while the field of the code has the focus.
        self.wait_without_button("Operate")

    def click_at(self, x: float, y: float):
        """Clicks into the scene."""
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            self.tab._mouse(kind, [x, y])

    @property
    def text(self) -> str:
        """All that the page says."""
        return self.tab.evaluate("document.body.innerText")

    def wait_for_text(self, text: str):
        """Waits until the page says something."""
        self.tab.wait_for(
            f"document.body.innerText.includes({json.dumps(text)})"
        )

    @property
    def errors(self) -> list[str]:
        """What has gone wrong, but for what is viser's own."""
        return [e for e in self.tab.console() if e != OF_VISER]


@contextmanager
def open_cockpit(
    url: str, size: tuple[int, int] = (800, 600)
) -> Iterator[CockpitTab]:
    """Opens a cockpit in a tab of its own, which draws no scene.

    `test_cockpit_pictures` looks at the scene.
    """
    with open_browser(size) as tab:
        tab.run_first(DRAW_NOTHING)
        yield CockpitTab(tab, url)
