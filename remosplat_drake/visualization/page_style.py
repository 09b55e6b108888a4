"""How the page's controls look: one style sheet, and labels that use it.

Meshcat has buttons and sliders only, and draws their names as HTML. So a
name that carries a class is how a control gets its place and its looks, and
the style sheet is part of a name, too. A row is laid out by the class of the
name in it, not by when it was added: a line of text may be replaced at any
time without moving a button under somebody's mouse.
"""

import html

TOPICS = (
    "supervisor",
    "robot",
    "log",
    "target",
    "map",
    "controller",
    "guidance",
)
"""Topics of the lines of text, in their order on the page."""

_ROWS = ".dg.main>ul>li"
_FONT = "-apple-system,'Segoe UI',Roboto,'Helvetica Neue',Arial,sans-serif"

# Controls of this project stand above those of other views (order 50), then
# come lines of text, then Meshcat's own tree.
_RULES = f"""
.dg.main{{width:344px!important;font:12px {_FONT};text-shadow:none}}
.dg.main>ul{{display:flex;flex-flow:row wrap;height:auto!important;
max-height:calc(100vh - 20px);overflow-y:auto;background:#1b1e23;
padding:0 8px 6px;box-sizing:border-box}}
.dg.main .close-button{{width:100%!important;background:#1b1e23;
border-top:1px solid #2a2e35;color:#8b95a5}}
{_ROWS}{{flex:1 1 100%;box-sizing:border-box}}
{_ROWS}.cr{{order:50;background:#1b1e23;border-bottom-color:#2a2e35}}
{_ROWS}.folder{{order:90}}
{_ROWS}:has(.remosplat-style){{display:none}}
.dg .property-name:has([class^=remosplat]){{text-overflow:clip}}

{_ROWS}:has(.remosplat-stop){{order:1;position:sticky;top:0;z-index:2;
height:64px;background:#c8102e;border:0;margin:0 -8px}}
{_ROWS}:has(.remosplat-release){{order:2;height:32px;background:#1f6f43;
border:0;margin:0 -8px 2px}}
{_ROWS}:has(.remosplat-stop):hover{{background:#a90d27}}
{_ROWS}:has(.remosplat-release):hover{{background:#185a36}}
.remosplat-stop,.remosplat-release{{display:block;text-align:center;
color:white}}
.remosplat-stop{{font:bold 26px/64px {_FONT}}}
.remosplat-release{{font:bold 13px/32px {_FONT}}}

{_ROWS}:has(.remosplat-heading){{order:10;height:30px;padding:6px 4px 0;
border:0;pointer-events:none}}
.remosplat-heading{{font:600 11px/24px {_FONT};color:#8b95a5;
letter-spacing:.06em;text-transform:uppercase}}

{_ROWS}:has(.remosplat-button){{order:10;flex:1 1 40%;height:30px;
margin:3px 4px;padding:0;border:1px solid #3b424d;border-radius:5px;
background:#2a2f38}}
{_ROWS}:has(.remosplat-button):hover{{background:#38404c}}
{_ROWS}:has(.remosplat-button):active{{background:#4a82c4}}
.remosplat-button{{display:block;text-align:center;line-height:28px;
color:#e8ebf0}}
.remosplat-key{{color:#8b95a5;font-size:11px}}

.dg.main>ul:not(.closed)>li.cr.function:not(:has([class^=remosplat])){{
height:30px;margin:3px 4px;padding:0 8px;border:1px solid #3b424d;
border-radius:5px;background:#23272e;color:#cfd5de}}

{_ROWS}:has(.remosplat-slider){{order:10;height:26px;line-height:26px;
padding:0 4px;border:0}}
{_ROWS}:has(.remosplat-slider) .property-name{{width:34%}}
{_ROWS}:has(.remosplat-slider) .c{{width:66%}}
{_ROWS}:has(.remosplat-slider) .slider{{border-radius:4px;height:16px;
margin-top:5px;overflow:hidden;background:#343a44}}
{_ROWS}:has(.remosplat-slider) .slider-fg{{background:#4a82c4}}
{_ROWS}:has(.remosplat-slider) input[type=text]{{color:#e8ebf0;
background:none;text-align:right;font:12px {_FONT}}}
.remosplat-slider{{display:flex;justify-content:space-between;
padding-right:12px;color:#cfd5de}}

{_ROWS}:has(.remosplat-note){{height:auto;border:0;padding:0 4px;
pointer-events:none}}
.dg .property-name:has(.remosplat-note){{white-space:normal;
line-height:17px;padding:3px 0;cursor:default}}
{_ROWS}:has(.remosplat-about-supervisor){{margin-top:10px}}
.remosplat-note{{color:#aab3c0}}
.remosplat-trouble{{color:#ffb454}}
.remosplat-note b{{font-weight:600;color:#e8ebf0}}

{_ROWS}:has(.remosplat-plot){{position:fixed;left:16px;z-index:1;padding:0;
height:auto;border:0;background:none;pointer-events:none}}
{_ROWS}:has(.remosplat-place-0){{bottom:156px}}
{_ROWS}:has(.remosplat-place-1){{bottom:16px}}
"""

_PLACES = "".join(
    f"{_ROWS}:has(.remosplat-about-{topic}){{order:{60 + k}}}"
    for k, topic in enumerate(TOPICS)
)

STYLE = (
    "<style>"
    + (_RULES + _PLACES).replace("\n", "").replace("'", '"')
    + '</style><span class="remosplat-style"></span>'
)
"""Name of a hidden button that carries the style sheet."""


def escaped(text: str) -> str:
    """Escapes a text so that the page shows it as it is.

    Meshcat puts a name between apostrophes of a script, so that even a
    backslash in it would not arrive.
    """
    return html.escape(" ".join(text.split())).replace("\\", "&#92;")


def heading(text: str) -> str:
    """Returns the name of a button that is the title of a group."""
    return f'<span class="remosplat-heading">{escaped(text)}</span>'


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


def note(topic: str, text: str, trouble: str = "") -> str:
    """Returns the name of a button that is a line of text about a topic.

    Args:
        topic: One of `TOPICS`; it is the title of the line, too.
        text: Text of the line.
        trouble: What has gone wrong; it stands out.
    """
    if trouble:
        trouble = f' <span class="remosplat-trouble">{escaped(trouble)}</span>'
    return (
        f'<span class="remosplat-note remosplat-about-{topic}">'
        f"<b>{topic.capitalize()}:</b> {escaped(text)}{trouble}</span>"
    )


def plot(place: int, svg: str) -> str:
    """Returns the name of a button that is a picture on the page's left.

    Args:
        place: 0 for the upper picture, 1 for the lower one.
        svg: An inline SVG without apostrophes and backslashes.
    """
    return f'<span class="remosplat-plot remosplat-place-{place}">{svg}</span>'


def _span(kind: str, inner: str) -> str:
    return f'<span class="remosplat-{kind}">{inner}</span>'
