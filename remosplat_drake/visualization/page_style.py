"""Names of the controls that Meshcat has on the page.

Meshcat has buttons and sliders only, and draws their names as HTML. So a name
that carries a class is how a control gets its looks, from `web/page.css`.
"""

import html

from remosplat_drake.visualization.page_state import RELEASE, START, STOP

TOPICS = (
    "start",
    "supervisor",
    "robot",
    "log",
    "target",
    "map",
    "splat",
    "controller",
    "guidance",
)
"""Topics of the lines of text, in their order on the page."""

BUTTONS = {
    START: '<span class="remosplat-start">START <small>Enter</small></span>',
    STOP: '<span class="remosplat-stop">STOP <small>Esc</small></span>',
    RELEASE: '<span class="remosplat-release">RELEASE</span>',
}
"""Names of the buttons that act on the run."""

KEYS = {START: "Enter", STOP: "Escape", RELEASE: ""}
"""Keys of these buttons. No browser clicks a focused button with Escape, as it
does with the space bar; and a release is not to be hit by chance."""


def escaped(text: str) -> str:
    """Escapes a text so that the page shows it as it is.

    Meshcat puts a name between apostrophes of a script, so that even a
    backslash in it would not arrive.
    """
    return html.escape(" ".join(text.split())).replace("\\", "&#92;")


def heading(text: str) -> str:
    """Returns the name of a button that is the title of a group."""
    return _span("heading", escaped(text))


def button(text: str, key: str = "") -> str:
    """Returns the name of a button; two of them share a row.

    Args:
        text: What the button says.
        key: Key that clicks it, to be shown; empty for none.
    """
    shown = f' <span class="remosplat-key">{key}</span>' if key else ""
    return _span("button", escaped(text) + shown)


def slider(text: str, keys: str = "") -> str:
    """Returns the name of a slider.

    Args:
        text: What the slider moves.
        keys: Keys that move it, to be shown.
    """
    return _span(
        "slider", f'{escaped(text)}<span class="remosplat-key">{keys}</span>'
    )


def _span(kind: str, inner: str) -> str:
    return f'<span class="remosplat-{kind}">{inner}</span>'
