"""`ClientPanel`: one browser's panel of the cockpit, beside the scene."""

import html
from typing import Protocol

import numpy as np
import viser

from remosplat_drake.cockpit.authority import is_whole
from remosplat_drake.cockpit.client_channel import ClientChannel
from remosplat_drake.cockpit.messages import PageContent
from remosplat_drake.cockpit.operator_panel import OperatorPanel
from remosplat_drake.cockpit.task_list import task_html
from remosplat_drake.cockpit.viewpoints import (
    FOLLOW,
    SCENE,
    VIEWS,
    Viewpoint,
    viewpoint,
)
from remosplat_drake.teleop.gamepad import GamepadState
from remosplat_drake.visualization import page_state as pages
from remosplat_drake.visualization.page_state import PageState

_COLOURS = {
    pages.LIVE: "#2b8a3e",
    pages.HELD: "#e67700",
    pages.STOPPED: "#c92a2a",
    pages.WAITING: "#1864ab",
}
_GREY = "#495057"

_SLOW = 0.85
"""The page shows the real-time factor if it is below this."""

_UNSEEN = (
    "The robot does not enter space that no camera has seen. Point the camera "
    "at the surroundings of the target, from the side from which the hand "
    "will come. The inside of objects always stays unseen."
)


class PageActions(Protocol):
    """The functions of the page that a client's panel calls."""

    def stop(self) -> None:
        """Stops the robot; every client may do so."""
        ...

    def admit(self, panel: "ClientPanel", code: str) -> str:
        """Lets a client operate, or returns the reason of a refusal."""
        ...

    def show_unseen(self, shown: bool) -> None:
        """Draws or hides the boundary of unseen space."""
        ...

    def age(self) -> float:
        """Returns the age of the page's content [s]."""
        ...


class ClientPanel:
    """One browser's panel: STOP, the robot's state, a code field, and views.

    The controls belong to this client: other clients cannot operate them.

    Args:
        client: The client.
        page_actions: Interface of the page that contains the panel.
        content: The page's content at present.
        shows_unseen: Whether the boundary of unseen space is drawn; None if the
            map has no such boundary.

    Attributes:
        client: The client.
        operator: The controls of an operator; None while the client is not the
            operator.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        page_actions: PageActions,
        content: PageContent,
        shows_unseen: bool | None,
    ):
        self.client = client
        self.operator: OperatorPanel | None = None
        self._page_actions = page_actions
        self._content = content
        self._follows = False
        gui = client.gui
        self._channel = ClientChannel(client, page_actions.age, self._lead)
        self._stop = gui.add_button("STOP", color="red", order=0.0)
        self._status = gui.add_html("", order=1.0)
        self._task = gui.add_html("", order=12.0, visible=False)
        self._add_stop()
        self._add_code(gui)
        self._add_views(gui, shows_unseen)
        self._look_from(SCENE)
        self.show(content)

    def _add_stop(self) -> None:
        @self._stop.on_click
        async def _(_):
            self._page_actions.stop()

        for key in ("escape", "space"):
            command = self.client.gui.add_command(f"STOP ({key})", hotkey=key)

            @command.on_trigger
            async def _(_):
                self._page_actions.stop()

    def _add_code(self, gui: viser.GuiApi) -> None:
        self._entry = gui.add_folder("Operate", order=5.0)
        with self._entry:
            self._code = gui.add_text("Code", "", hint="shown in the terminal")
            button = gui.add_button("Operate")
            self._refusal = gui.add_markdown("", visible=False)

        def enter():
            # The operator's controls take long to add, so they are not added in
            # the event loop that handles STOP.
            self._refuse(self._page_actions.admit(self, self._code.value))

        @button.on_click
        def _(_):
            enter()

        @self._code.on_update
        def _(event: viser.GuiEvent):
            if event.client is not None and is_whole(self._code.value):
                enter()

    def _refuse(self, reason: str) -> None:
        self._refusal.content = reason
        self._refusal.visible = bool(reason)

    def _add_views(self, gui: viser.GuiApi, shows_unseen: bool | None) -> None:
        with gui.add_folder("View", order=30.0):
            views = gui.add_button_group("From", VIEWS)
            if shows_unseen is not None:
                veil = gui.add_checkbox(
                    "Unseen space", shows_unseen, hint=_UNSEEN
                )

                @veil.on_update
                async def _(event: viser.GuiEvent):
                    if event.client is not None:
                        self._page_actions.show_unseen(veil.value)

        @views.on_click
        async def _(_):
            self._follows = views.value == FOLLOW
            if not self._follows:
                self._look_from(views.value)

    def _look_from(self, view: str) -> None:
        self._set_camera(viewpoint(view, self._content))

    def _set_camera(self, view: Viewpoint) -> None:
        with self.client.atomic():
            self.client.camera.position = view.p_WC
            self.client.camera.look_at = view.p_WT
            self.client.camera.up_direction = view.up_W

    def show(self, content: PageContent, pace: float | None = None) -> None:
        """Shows the run's state at one moment.

        Args:
            content: The page's content at that moment.
            pace: Simulated seconds per second; None if unknown.
        """
        before, self._content = self._content, content
        status = _status(content, pace)
        if status != self._status.content:
            self._status.content = status
            self._stop.disabled = pages.STOP not in content.state.buttons
        task = task_html(content.outline)
        if task != self._task.content:
            self._task.content, self._task.visible = task, bool(task)
        if self.operator is not None:
            self.operator.show(content)
        if self._follows:
            step = content.X_WB[:3, 3] - before.X_WB[:3, 3]
            if np.abs(step).max() > 1e-4:
                camera = self.client.camera
                with self.client.atomic():
                    camera.position = camera.position + step
                    camera.look_at = camera.look_at + step

    def _lead(self, gamepad: GamepadState | None) -> None:
        if self.operator is not None:
            self.operator.lead(gamepad)

    def operate(self, operator: OperatorPanel) -> None:
        """Gives the client the controls of an operator."""
        self.operator = operator
        self._code.value = ""
        self._entry.visible = False

    def retire(self) -> None:
        """Takes the controls of an operator away."""
        if self.operator is not None:
            self.client.scene.remove_click_callback()
            self.operator.remove()
            self.operator = None
            self._entry.visible = True


def _status(content: PageContent, pace: float | None) -> str:
    """The robot's state, as HTML."""
    state: PageState = content.state
    colour = _COLOURS.get(state.phase, _GREY)
    lines = [
        f'<div style="background:{colour};color:white;font-weight:700;'
        f'padding:6px 10px;border-radius:6px">{html.escape(state.title)}'
        f'<div style="font-weight:400">{html.escape(state.text)}</div></div>'
    ]
    for name, text in (("Target", content.target), ("Map", content.map)):
        if text:
            lines.append(f"<div><b>{name}</b> {html.escape(text)}</div>")
    if pace is not None and pace < _SLOW:
        lines.append(f"<div><b>Slow</b> {pace:.1f} of real time</div>")
    if content.trouble:
        lines.append(
            f'<div style="color:#c92a2a"><b>{html.escape(content.trouble)}</b>'
            "</div>"
        )
    body = "".join(lines)
    return (
        '<div style="padding:0 12px 6px;font-size:13px;line-height:1.45;'
        f'display:grid;gap:4px">{body}</div>'
    )
