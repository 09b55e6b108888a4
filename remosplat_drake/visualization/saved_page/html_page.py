"""`add_player`: a static page of Meshcat with a player and an account."""

import html
import json
from collections.abc import Sequence

from remosplat_drake.visualization.page_state import PageState
from remosplat_drake.visualization.saved_page.account import Account
from remosplat_drake.visualization.saved_page.archive import resource
from remosplat_drake.visualization.toggle import Toggle

_END = "</body>"


def add_player(
    page: str,
    account: Account | None,
    *,
    state: PageState | None = None,
    toggles: Sequence[Toggle] = (),
    badge: str = "",
) -> str:
    """Adds to a static page what its server has shown beside the scene.

    Args:
        page: The page, as `Meshcat.StaticHtml` has made it.
        account: What is to be told of the run; None if nothing has moved.
        state: How things stand, as the page says it.
        toggles: The buttons that show and hide parts of the scene.
        badge: The verdict on the map, as `page_style.badge` makes it.
    """
    before, end, after = page.rpartition(_END)
    if not end:
        before, after = page, ""
    data = {
        "begin": account.begin if account else 0.0,
        "idle": account.idle() if account else [],
        "toggles": [
            {"states": t.states, "state": t.state, "key": t.key}
            for t in toggles
        ],
    }
    return "".join(
        [
            before,
            f"<style>{resource('page.css')}</style>",
            _bar(account.state if account else state),
            f'<div id="panel">{badge}{_panel(account, toggles)}</div>',
            '<div id="player"><button id="play">Play</button><input id="time"'
            ' type="range" min="0" step="any" value="0" aria-label="time">'
            '<span id="clock"></span></div>',
            f'<script id="account" type="application/json">{_script(data)}'
            f"</script><script>{resource('page.js')}</script>",
            end,
            after,
        ]
    )


def _script(data: dict) -> str:
    """JSON that cannot end the script in which it stands."""
    return json.dumps(data).replace("<", "\\u003c")


def _bar(state: PageState | None) -> str:
    if state is None:
        return '<div id="bar"></div>'
    return (
        f'<div id="bar" class="{state.phase}"><b>{html.escape(state.title)}</b>'
        f"<span>{html.escape(state.text)}</span></div>"
    )


def _panel(account: Account | None, toggles: Sequence[Toggle]) -> str:
    parts = []
    if account is not None:
        parts += _measured(account)
    buttons = "".join(
        f"<button>{html.escape(t.label)}<span>{html.escape(t.key)}</span>"
        "</button>"
        for t in toggles
    )
    parts.append(f'<h2>Scene</h2><div id="toggles">{buttons}</div>')
    if account is not None:
        entries = "".join(
            f'<li><i style="background:{color}"></i>{html.escape(text)}</li>'
            for color, text in account.legend
        )
        parts.append(f'<h2>Legend</h2><ul id="legend">{entries}</ul>')
    return "".join(parts)


def _measured(account: Account) -> list[str]:
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td>{html.escape(value)}</td></tr>"
        for name, value in account.facts
    )
    moments = [*account.moments, *filter(None, [account.closest()])]
    events = "".join(
        f'<button data-time="{m.time:.3f}"><time>{m.time:.1f} s</time>'
        f"<span>{html.escape(m.text)}</span></button>"
        for m in sorted(moments, key=lambda m: m.time)
    )
    return [
        f"<h2>Result</h2><table>{rows}</table>",
        f"<h2>Over time</h2>{''.join(account.plots())}",
        f'<h2>Events</h2><div id="events">{events}</div>',
    ]
