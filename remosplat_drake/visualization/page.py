"""`MeshcatPage`: the browser page that all views draw on."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pydrake.geometry import Cylinder, Meshcat, MeshcatParams, Rgba
from pydrake.math import RigidTransform

from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.visualization import page_style
from remosplat_drake.visualization.page_state import PageState
from remosplat_drake.visualization.saved_page.account import Account
from remosplat_drake.visualization.saved_page.archive import pack
from remosplat_drake.visualization.saved_page.html_page import add_player
from remosplat_drake.visualization.toggle import Toggle

ROOT = "/remosplat"
"""Path in the scene tree below which everything of this project is."""

LIVE = f"{ROOT}/live"
"""Path below which is what a recording cannot hold, and therefore hides."""

_FLOOR_RADIUS = 30.0
_FLOOR_DROP = 0.006  # A captured floor must not fight with the drawn one.
_CAMERA = "/Cameras/default/rotated/<object>"
_SKY = [0.94, 0.96, 0.98]
_NADIR = [0.50, 0.52, 0.54]
_FLOOR = Rgba(0.70, 0.73, 0.77)
_LIGHTS = {
    "AmbientLight": {"intensity": 0.7},
    "PointLightNegativeX": {"visible": False},
    "PointLightPositiveX": {"visible": False},
    # A sun over the camera's shoulder: light without a horizon, and the
    # only one with a shadow.
    "FillLight": {
        "position": [-4.5, -2.2, 7.0],
        "intensity": 2.3,
        "castShadow": True,
        "shadow.radius": 4.0,
        "shadow.bias": -0.0005,
        "shadow.normalBias": 0.01,
        "shadow.mapSize.width": 2048.0,
        "shadow.mapSize.height": 2048.0,
    },
}


class MeshcatPage:
    """A Meshcat server whose page has a sky, a floor, shadows and controls.

    Args:
        port: TCP port; None takes the first free one from 7000 on.
        host: Network interface to listen on; "*" stands for all. The page's
            controls can steer a robot, so by default only this computer may
            connect.
        floor: Whether to draw a floor.

    Attributes:
        meshcat: Drake's server; anything else may be drawn on it, too.
        status: The lines of text on show, by their topics.
        state: How things stand, as the page says it; None before it is told.

    Raises:
        RemoSplatError: The port is taken or out of range.

    Example:
        >>> import remosplat_drake as rs
        >>> page = rs.MeshcatPage()
        >>> page.url
        'http://localhost:...'
    """

    def __init__(
        self,
        *,
        port: int | None = None,
        host: str = "localhost",
        floor: bool = True,
    ):
        self.meshcat = _start_server(port, host)
        self._toggles: list[Toggle] = []
        self.status: dict[str, str] = {}
        self.state: PageState | None = None
        self._labels: dict[str, str] = {}
        self._clicks = dict.fromkeys(page_style.BUTTONS, 0)
        self.meshcat.AddButton(page_style.STYLE)
        self._dress(floor)
        self.look_from(p_WC=(-1.2, -2.8, 2.0), p_WT=(0.65, 0.1, 0.38))

    @property
    def url(self) -> str:
        """Address of the page, to open in a browser."""
        return self.meshcat.web_url()

    def look_from(self, p_WC: Sequence[float], p_WT: Sequence[float]):
        """Moves the page's camera.

        Args:
            p_WC: Position of the camera in W [m].
            p_WT: Point that it looks at in W [m].
        """
        self.meshcat.SetCameraPose(
            camera_in_world=np.array(p_WC, float),
            target_in_world=np.array(p_WT, float),
        )

    def add_toggle(self, toggle: Toggle):
        """Adds a button to those that `poll` serves."""
        self._toggles.append(toggle)

    def poll(self):
        """Serves all buttons that were clicked since the last call."""
        for toggle in self._toggles:
            toggle.poll()

    def show(self, state: PageState):
        """Says how things stand, and offers the buttons that do something.

        Args:
            state: How things stand.
        """
        if state == self.state:
            return
        before = self.state.buttons if self.state else ()
        self.state = state
        for button in before:
            if button not in state.buttons:
                name = page_style.BUTTONS[button]
                self._clicks[button] += self.meshcat.GetButtonClicks(name)
                self.meshcat.DeleteButton(name)
        for button in state.buttons:
            if button not in before:
                self.meshcat.AddButton(
                    page_style.BUTTONS[button], page_style.KEYS[button]
                )
        self.set_label("bar", page_style.bar(state))

    def clicks(self, button: str) -> int:
        """Returns how often START, STOP or RELEASE was pressed.

        Args:
            button: The button, which need not be there now.
        """
        count = self._clicks[button]
        if self.state is not None and button in self.state.buttons:
            count += self.meshcat.GetButtonClicks(page_style.BUTTONS[button])
        return count

    def end(self, state: PageState):
        """Says how a run has ended; what was said of its motion goes away.

        Args:
            state: How things stand now.
        """
        self.show(state)
        for topic in ("supervisor", "robot", "controller", "guidance"):
            self.set_status("", topic)

    def set_status(
        self, text: str, topic: str = "controller", trouble: str = ""
    ):
        """Shows a line of text below the controls, one line for each topic.

        It is sent only when it changes. Lines keep their order and move no
        button.

        Args:
            text: Text of the line; without any text the line goes away.
            topic: Topic of the line, one of `page_style.TOPICS`.
            trouble: What has gone wrong; it stands out at the end of the
                line.
        """
        said = f"{text} {trouble}".strip()
        self.status[topic] = said
        label = page_style.note(topic, text, trouble) if said else ""
        self.set_label(topic, label)

    def set_label(self, place: str, label: str):
        """Replaces a label, which is a button without a function.

        Meshcat has no text and no pictures, but draws buttons' names as
        HTML. The new one comes before the old one goes: nothing blinks.

        Args:
            place: Name of the place; an earlier label there goes.
            label: The new label, made by `page_style`; empty for none.
        """
        before = self._labels.get(place, "")
        if label == before:
            return
        if label:
            self.meshcat.AddButton(label)
        if before:
            self.meshcat.DeleteButton(before)
        self._labels[place] = label

    def start_recording(self, start: float = 0.0):
        """Records all motion from now on, for replay in the page.

        Args:
            start: Time of the diagram at which the recording begins [s].
        """
        self.meshcat.DeleteRecording()
        self.meshcat.StartRecording(frames_per_second=16)
        self.meshcat.get_mutable_recording().set_start_time(start)

    def pause_recording(self):
        """Records no more: what a replay holds is in memory."""
        self.meshcat.StopRecording()

    def finish_recording(self):
        """Stops recording; the page then replays, also when saved."""
        start = self.meshcat.get_mutable_recording().start_time()
        self.meshcat.SetProperty(
            LIVE, "visible", False, time_in_recording=start
        )
        self.meshcat.StopRecording()
        self.meshcat.PublishRecording()
        self.meshcat.SetProperty(LIVE, "visible", True)

    def save_html(self, path: str | Path, account: Account | None = None):
        """Writes the page as one file that needs neither server nor network.

        The file is written atomically, compressed, and carries a player with
        a time line. What was said of the run while it went on is not part of
        it: that is what the account is for.

        Args:
            path: The HTML file.
            account: What is to be told of the run; None if nothing has moved.

        Raises:
            FileError: The file cannot be written.
        """
        path = Path(path)
        badge = self._labels.get("badge", "")
        page = add_player(
            self.meshcat.StaticHtml(),
            account,
            state=self.state,
            toggles=self._toggles,
            badge=badge,
        )
        with atomic_write(path) as file:
            file.write(pack(page, path.stem))

    def _dress(self, floor: bool):
        meshcat = self.meshcat
        meshcat.SetProperty("/Background/<object>", "top_color", _SKY)
        meshcat.SetProperty("/Background/<object>", "bottom_color", _NADIR)
        meshcat.SetProperty(
            "/Background/<object>", "render_environment_map", False
        )
        for path in ("/Grid", "/Axes"):
            meshcat.SetProperty(path, "visible", False)
        for light, properties in _LIGHTS.items():
            for name, value in properties.items():
                node = f"/Lights/{light}"
                # Visibility belongs to the tree, the rest to the light.
                if name != "visible":
                    node += "/<object>"
                meshcat.SetProperty(node, name, value)
        meshcat.SetProperty(_CAMERA, "zoom", 2.2)
        if floor:
            path = f"{ROOT}/floor"
            meshcat.SetObject(path, Cylinder(_FLOOR_RADIUS, 0.01), _FLOOR)
            meshcat.SetTransform(
                path, RigidTransform([1.0, 0.0, -0.005 - _FLOOR_DROP])
            )


def _start_server(port: int | None, host: str) -> Meshcat:
    if port is not None and not 1024 <= port <= 65535:
        raise RemoSplatError(
            f"meshcat port {port} is out of range; valid: 1024 to 65535"
        )
    try:
        return Meshcat(
            MeshcatParams(host=host, port=port, show_stats_plot=False)
        )
    except RuntimeError as error:
        if port is None:
            raise RemoSplatError(
                f"meshcat found no free port on host {host!r}"
            ) from error
        raise RemoSplatError(
            f"meshcat port {port} is taken on host {host!r};"
            " choose another one, or none for the first free one"
        ) from error
