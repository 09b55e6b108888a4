"""Makes the names of Meshcat's controls, which define their style.

Meshcat has only buttons and sliders, and inserts their names into the page as
HTML. A name that contains an HTML class therefore gives a control a style of
`web/page.css`.
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
"""Keys of START and STOP. The key of STOP is Escape, not the space bar, since
browsers click a focused button if the space bar is pressed. RELEASE has no key,
so that a person does not press it by accident."""


def escaped(text: str) -> str:
    """Escapes a text so that the page shows it unchanged.

    Meshcat inserts a name between apostrophes in a script, so backslashes must
    be escaped, too.
    """
    return html.escape(" ".join(text.split())).replace("\\", "&#92;")


def heading(text: str) -> str:
    """Returns the name of a button that is the title of a group of controls."""
    return _span("heading", escaped(text))


def button(text: str, key: str = "") -> str:
    """Returns the name of a button; a row of the page holds two buttons.

    Args:
        text: Text on the button.
        key: Displayed key that clicks the button; empty if no key clicks it.
    """
    shown = f' <span class="remosplat-key">{key}</span>' if key else ""
    return _span("button", escaped(text) + shown)


def hidden(action: str, index: int = 0) -> str:
    """Returns the name of a hidden button, which another control clicks.

    Args:
        action: Name of the button's action, by which `web/task.js` finds the
            button.
        index: Index of the object on which the button acts.
    """
    return (
        f'<span class="remosplat-hidden remosplat-{action}"'
        f' data-index="{index}"></span>'
    )


def slider(text: str, keys: str = "") -> str:
    """Returns the name of a slider.

    Args:
        text: Text of the slider: the quantity that it changes.
        keys: Displayed keys that move the slider.
    """
    return _span(
        "slider", f'{escaped(text)}<span class="remosplat-key">{keys}</span>'
    )


def _span(kind: str, inner: str) -> str:
    return f'<span class="remosplat-{kind}">{inner}</span>'
