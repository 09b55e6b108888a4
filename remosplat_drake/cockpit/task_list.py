"""`task_html`: lists the jobs and steps of a task for the cockpit."""

import html

from remosplat_drake.signals.task_outline import (
    AHEAD,
    DONE,
    FAILED,
    PRESENT,
    OutlineLine,
    TaskOutline,
)

_STYLES = {
    AHEAD: ("\u25cb", "#495057"),
    PRESENT: ("\u25b6", "#1864ab;font-weight:700"),
    DONE: ("\u2713", "#2b8a3e"),
    FAILED: ("\u2717", "#c92a2a"),
}
"""Mark and style of a line, keyed by the state of the job or step."""


def task_html(outline: TaskOutline) -> str:
    """Returns a task's jobs and steps as HTML, the present step marked.

    Args:
        outline: The task.

    Returns:
        The list with the reasons of failures; empty if there are none.
    """
    parts = [_line(line) for line in outline.lines]
    parts += [
        f'<div style="color:#c92a2a">{html.escape(text)}</div>'
        for text in outline.failures
    ]
    if not parts:
        return ""
    return (
        '<div style="padding:0 12px 6px;font-size:13px;line-height:1.45">'
        f"{''.join(parts)}</div>"
    )


def _line(line: OutlineLine) -> str:
    mark, style = _STYLES[line.state]
    indent = 18 if line.is_step else 0
    current = ' aria-current="step"' if line.state == PRESENT else ""
    return (
        f'<div{current} data-state="{line.state}"'
        f' style="margin-left:{indent}px;color:{style}">'
        f"{mark} {html.escape(line.text)}</div>"
    )
