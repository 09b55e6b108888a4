"""How the page looks: one style sheet, and labels that use it.

Meshcat has buttons and sliders only, and draws their names as HTML. So a
name that carries a class is how a control gets its place and its looks, and
the style sheet is part of a name, too. A row is laid out by the class of the
name in it, not by when it was added: a line of text may be replaced at any
time without moving a button under somebody's mouse.

Nothing lies over the scene: a bar across the top says how things stand, the
panel is beside the scene, or below it where the page is upright.
"""

import html

from remosplat_drake.visualization.page_state import (
    RELEASE,
    START,
    STOP,
    PageState,
)

TOPICS = (
    "supervisor",
    "robot",
    "log",
    "target",
    "map",
    "splat",
    "controller",
    "guidance",
    "traces",
)
"""Topics of the lines of text, in their order on the page."""

_ROWS = ".dg.main>ul>li"
_FONT = "-apple-system,'Segoe UI',Roboto,'Helvetica Neue',Arial,sans-serif"

_LAYOUT = f"""
:root{{--bar:52px;--panel:344px;--stop:64px;--release:160px}}
#meshcat-pane{{position:fixed;left:0;top:var(--bar);
width:calc(100vw - var(--panel))!important;
height:calc(100dvh - var(--bar))!important}}
.dg.main{{position:fixed!important;top:var(--bar)!important;right:0!important;
width:var(--panel)!important;height:calc(100dvh - var(--bar));
overflow-y:auto;background:#1b1e23;font:12px {_FONT};text-shadow:none}}
.dg.main>ul{{display:flex;flex-flow:row wrap;align-content:flex-start;
height:auto!important;background:#1b1e23;padding:0 8px 6px;
box-sizing:border-box;overflow:visible!important}}
.dg.main .close-button{{position:static;width:100%!important;
background:#1b1e23;border-top:1px solid #2a2e35;color:#8b95a5}}
#status-message{{top:0;left:0!important;width:100vw!important;z-index:9;
line-height:var(--bar);height:var(--bar);background:#ffb454!important}}
body:has(#status-message[style*=block]) {_ROWS}:has(.remosplat-gone){{
display:none}}

@media (orientation:portrait) and (max-width:800px){{
:root{{--bar:88px;--panel:0px;--release:104px}}
#meshcat-pane{{height:50dvh!important}}
.dg.main{{top:calc(50dvh + var(--bar))!important;width:100vw!important;
height:calc(50dvh - var(--bar))}}
.dg .remosplat-bar{{flex-flow:column;align-items:start;justify-content:center;
gap:0;padding:0 12px;font-size:13px;line-height:16px}}
.dg .remosplat-bar b{{font-size:17px;line-height:20px}}
}}
@media (orientation:landscape) and (max-height:500px){{
:root{{--bar:44px;--panel:260px;--stop:56px}}
}}
"""

# Controls of this project stand above those of other views (order 50), then
# come lines of text, pictures, and Meshcat's own tree.
_RULES = f"""
{_ROWS}{{flex:1 1 100%;box-sizing:border-box}}
{_ROWS}.cr{{order:50;background:#1b1e23;border-bottom-color:#2a2e35}}
{_ROWS}.folder{{order:90}}
{_ROWS}:has(.remosplat-style){{display:none}}
.dg .property-name:has([class^=remosplat]){{text-overflow:clip}}

{_ROWS}:has(.remosplat-bar){{position:fixed;z-index:3;top:0;left:0;width:100vw;
height:var(--bar);margin:0;padding:0;border:0;pointer-events:none;
background:#1b1e23}}
{_ROWS}:has(.remosplat-is-waiting){{background:#1d4f91}}
{_ROWS}:has(.remosplat-is-held){{background:#9a5b00}}
{_ROWS}:has(.remosplat-is-stopped){{background:#c8102e}}
{_ROWS}:has(.remosplat-is-reached){{background:#1f6f43}}
{_ROWS}:has(.remosplat-is-missed){{background:#8a5a00}}
.dg .property-name:has(.remosplat-bar){{white-space:normal;padding:0}}
.remosplat-bar{{display:flex;align-items:center;gap:14px;box-sizing:border-box;
height:var(--bar);padding:0 16px;color:#fff;font:15px/19px {_FONT}}}
.remosplat-bar b{{font-size:20px;white-space:nowrap}}
.remosplat-bar i{{font-style:normal;max-height:100%;overflow:hidden}}
.remosplat-is-live b::before{{content:"";display:inline-block;width:10px;
height:10px;margin:0 9px 2px 0;border-radius:5px;background:#4cc38a}}
:root:has(.remosplat-release) .remosplat-bar{{
padding-right:calc(var(--release) + 16px)}}

{_ROWS}:has(.remosplat-release){{position:fixed;z-index:4;top:4px;right:8px;
width:var(--release);height:calc(var(--bar) - 8px);padding:0;border:0;
border-radius:6px;background:#fff}}
.remosplat-release{{display:block;text-align:center;color:#8c0b20;
font:bold 15px/calc(var(--bar) - 8px) {_FONT}}}
{_ROWS}:has(.remosplat-stop),{_ROWS}:has(.remosplat-start){{order:1;
position:sticky;top:0;z-index:2;height:var(--stop);border:0;margin:0 -8px;
padding:0}}
{_ROWS}:has(.remosplat-stop){{background:#c8102e;
box-shadow:inset 0 0 0 2px #ffffff40}}
{_ROWS}:has(.remosplat-stop):hover{{background:#a90d27}}
{_ROWS}:has(.remosplat-start){{background:#1f6f43}}
{_ROWS}:has(.remosplat-start):hover{{background:#185a36}}
.remosplat-stop,.remosplat-start{{display:block;text-align:center;color:#fff;
font:bold 26px/var(--stop) {_FONT}}}
.remosplat-stop small,.remosplat-start small{{font-weight:normal;font-size:14px;
opacity:.8}}

{_ROWS}:has(.remosplat-badge){{order:3;height:auto;border:0;padding:0;
margin:8px 0 0;pointer-events:none}}
.dg .property-name:has(.remosplat-badge){{white-space:normal;padding:0}}
.remosplat-badge{{display:block;padding:6px 8px;border-radius:5px;
border-left:6px solid;background:#262b33;color:#cfd5de;line-height:16px}}
.remosplat-good{{border-color:#4cc38a}}
.remosplat-fair,.remosplat-unknown{{border-color:#ffb454}}
.remosplat-poor{{border-color:#ff5c5c}}
.remosplat-badge b{{color:#fff}}

{_ROWS}:has(.remosplat-heading){{order:10;height:30px;padding:6px 4px 0;
border:0;pointer-events:none}}
.remosplat-heading{{font:600 11px/24px {_FONT};color:#8b95a5;
letter-spacing:.06em;text-transform:uppercase}}

{_ROWS}:has(.remosplat-button),{_ROWS}:has(.remosplat-toggle){{order:10;
flex:1 1 40%;height:30px;margin:3px 4px;padding:0;border:1px solid #3b424d;
border-radius:5px;background:#2a2f38}}
{_ROWS}:has(.remosplat-toggle){{order:50;flex:1 1 90%}}
{_ROWS}:has(.remosplat-button):hover,
{_ROWS}:has(.remosplat-toggle):hover{{background:#38404c}}
{_ROWS}:has(.remosplat-button):active,
{_ROWS}:has(.remosplat-toggle):active{{background:#4a82c4}}
.remosplat-button{{display:block;text-align:center;line-height:28px;
color:#e8ebf0}}
.remosplat-toggle{{display:flex;justify-content:space-between;
padding:0 10px;line-height:28px;color:#e8ebf0}}
.remosplat-key{{color:#8b95a5;font-size:11px}}
.remosplat-toggle .remosplat-key{{align-self:center;min-width:16px;
line-height:16px;text-align:center;border:1px solid #59616e;border-radius:3px;
color:#cfd5de}}

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
.remosplat-note{{color:#aab3c0}}
.remosplat-trouble{{color:#ffb454}}
.remosplat-note b{{font-weight:600;color:#e8ebf0}}

{_ROWS}:has(.remosplat-plot){{order:70;flex:1 1 240px;padding:0;margin:4px;
height:auto;border:0;background:none;pointer-events:none}}
.dg .property-name:has(.remosplat-plot){{padding:0}}
.remosplat-plot svg{{width:100%;height:auto}}
"""

# Meshcat's own player, the third of its folders: put first when a run is over,
# even where the rest of Meshcat's controls is folded away.
_PLAYER = ".dg.main>ul:has(.remosplat-is-over)>li.folder:nth-child(3)"
_REPLAY = f"""
{_PLAYER}{{order:1;height:auto!important;overflow:visible!important;
margin:8px 0 0;border:0}}
{_PLAYER} li.title,{_PLAYER} li.folder li.folder,
{_PLAYER} .cr.number:not(.has-slider){{display:none}}
{_PLAYER} li.folder,{_PLAYER} li>*{{height:auto!important;border:0}}
{_PLAYER} ul ul{{display:flex;flex-flow:row wrap;gap:6px}}
{_PLAYER} .cr.function{{flex:1;height:36px!important;line-height:36px;padding:0;
text-align:center;border:1px solid #3b424d!important;border-radius:5px;
background:#2a2f38}}
{_PLAYER} .cr.has-slider{{order:-1;flex:1 1 100%;height:36px!important;
line-height:36px;border:0;background:none;overflow:visible}}
{_PLAYER} .has-slider .property-name{{width:14%}}
{_PLAYER} .has-slider .c{{width:86%}}
{_PLAYER} .has-slider .slider{{width:74%;height:26px;margin:5px 0 0;
border-radius:4px;overflow:hidden;background:#343a44}}
{_PLAYER} .has-slider .slider-fg{{height:100%!important;background:#4a82c4}}
{_PLAYER} .has-slider input{{width:22%;height:26px;margin-top:5px;
box-sizing:border-box;background:none;color:#e8ebf0}}
"""

_PLACES = "".join(
    f"{_ROWS}:has(.remosplat-about-{topic}){{order:{60 + k}}}"
    for k, topic in enumerate(TOPICS)
)

# Meshcat measures its picture when the window changes, not when a style does.
_MEASURE = (
    '<meta name="viewport" content="width=device-width,initial-scale=1">'
    '<img class="remosplat-style" src="data:,"'
    ' onerror="dispatchEvent(new Event(`resize`))">'
)

STYLE = (
    "<style>"
    + (_LAYOUT + _RULES + _REPLAY + _PLACES)
    .replace("\n", " ")
    .replace("'", '"')
    + "</style>"
    + _MEASURE
)
"""Name of a hidden button that carries the style sheet."""

BUTTONS = {
    START: '<span class="remosplat-start">START <small>Enter</small></span>',
    STOP: (
        '<span class="remosplat-stop remosplat-gone">STOP'
        " <small>Esc</small></span>"
    ),
    RELEASE: '<span class="remosplat-release remosplat-gone">RELEASE</span>',
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


def bar(state: PageState) -> str:
    """Returns the name of a button that is the bar across the page's top."""
    over = " remosplat-is-over" if state.is_over else ""
    return (
        f'<span class="remosplat-bar remosplat-gone'
        f' remosplat-is-{state.phase}{over}">'
        f"<b>{escaped(state.title)}</b> <i>{escaped(state.text)}</i></span>"
    )


def badge(grade: str, title: str, text: str) -> str:
    """Returns the name of a button that is a verdict.

    Args:
        grade: One of `map_grade`'s, which gives it a colour.
        title: The verdict in a word or two.
        text: What it rests on.
    """
    return (
        f'<span class="remosplat-badge remosplat-{grade}">'
        f"<b>{escaped(title)}</b> {escaped(text)}</span>"
    )


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


def toggle(text: str, key: str) -> str:
    """Returns the name of a button that shows or hides something.

    Args:
        text: What it shows.
        key: Key that clicks it, to be shown.
    """
    return _span(
        "toggle", f'{escaped(text)}<span class="remosplat-key">{key}</span>'
    )


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
    """Returns the name of a button that is a picture in the panel.

    Args:
        place: 0 for the upper picture, 1 for the lower one.
        svg: An inline SVG without apostrophes and backslashes.
    """
    return f'<span class="remosplat-plot remosplat-place-{place}">{svg}</span>'


def _span(kind: str, inner: str) -> str:
    return f'<span class="remosplat-{kind}">{inner}</span>'
