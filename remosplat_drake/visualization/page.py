"""`MeshcatPage`: the browser page that all views draw on."""

import dataclasses as dc
import weakref
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, MeshcatParams

from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.tcp_port import is_free
from remosplat_drake.signals.task_outline import TaskOutline
from remosplat_drake.visualization import page_style
from remosplat_drake.visualization.live_page.live_scene import LiveScene
from remosplat_drake.visualization.live_page.newest import Newest
from remosplat_drake.visualization.live_page.page_files import page_files
from remosplat_drake.visualization.live_page.page_server import PageServer
from remosplat_drake.visualization.page_state import PageState
from remosplat_drake.visualization.saved_page.account import Account
from remosplat_drake.visualization.saved_page.archive import pack
from remosplat_drake.visualization.saved_page.html_page import saved_page
from remosplat_drake.visualization.scene_look import LIVE, dress
from remosplat_drake.visualization.toggle import Toggle

_FIRST_PORT = 7000


class MeshcatPage:
    """A browser page with a 3D scene (Meshcat), a bar, a panel and a player.

    The bar shows the robot's state. Meshcat's server sends the shapes of the
    scene and receives presses of buttons. A second server, `PageServer`, serves
    the page itself, and the newest poses and texts. A browser that draws slowly
    therefore skips older poses and does not lag behind.

    Args:
        port: TCP port; None means the first free port from 7000 on. Meshcat's
            server uses another free port.
        host: Network interface to listen on; "*" stands for all interfaces. By
            default, only this computer can connect, since the page's controls
            can move a robot.
        floor: Whether to draw a floor.

    Attributes:
        meshcat: Drake's Meshcat server. Your program may draw on it, too.
        scene: Moves objects in the scene.
        port: The TCP port.
        status: The displayed lines of text, keyed by topic.
        state: The robot's state that the page shows; None before the first
            state.

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
        self._newest = Newest()
        self._server = _start_server(port, host, self._newest)
        self.port = self._server.port
        self.meshcat = _start_meshcat(host)
        session = self._server.session
        files = page_files(self.meshcat.port(), session)
        self._server.serve(files, self.meshcat.web_url())
        weakref.finalize(self, self._server.close)
        self.scene = LiveScene(self.meshcat, self._newest)
        self._host = "localhost" if host == "*" else host
        self._toggles: list[Toggle] = []
        self.status: dict[str, str] = {}
        self._notes: dict[str, tuple[str, str]] = {}
        self.state: PageState | None = None
        self._clicks = dict.fromkeys(page_style.BUTTONS, 0)
        dress(self.meshcat, floor=floor)
        self.look_from(p_WC=(-1.2, -2.8, 2.0), p_WT=(0.65, 0.1, 0.38))

    @property
    def url(self) -> str:
        """Address of the page, to open in a browser."""
        return f"http://{self._host}:{self.port}"

    def look_from(self, p_WC: Sequence[float], p_WT: Sequence[float]):
        """Moves the page's camera.

        Args:
            p_WC: Position of the camera in W [m].
            p_WT: Point in W that the camera looks at [m].
        """
        self.meshcat.SetCameraPose(
            camera_in_world=np.array(p_WC, float),
            target_in_world=np.array(p_WT, float),
        )

    def beat(self):
        """Marks the page's content as up to date at this moment.

        From the first call until the end of the run, the page shows the age of
        its content.
        """
        self._server.beat()

    def add_toggle(self, toggle: Toggle):
        """Adds a button that shows or hides parts of the scene.

        Args:
            toggle: The button.
        """
        for path, visible in toggle.visible.items():
            self.meshcat.SetProperty(path, "visible", visible)
        self._toggles.append(toggle)
        self._newest.put(("scene",), [dc.asdict(t) for t in self._toggles])

    def show(self, state: PageState):
        """Shows the robot's state, and the buttons that have an effect now.

        Args:
            state: The robot's state.
        """
        if state == self.state:
            return
        before = self.state.buttons if self.state else ()
        self.state = state
        # The text is sent before the buttons, since a browser may receive these
        # later.
        self._newest.put(("bar",), state.document())
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

    def clicks(self, button: str) -> int:
        """Returns the number of presses of START, STOP or RELEASE.

        Args:
            button: The button, which may be hidden at present.
        """
        count = self._clicks[button]
        if self.state is not None and button in self.state.buttons:
            count += self.meshcat.GetButtonClicks(page_style.BUTTONS[button])
        return count

    def end(self, state: PageState):
        """Shows the outcome of a run, and removes texts about its motion.

        Args:
            state: The robot's state now.
        """
        self._server.rest()
        self.show(state)
        for topic in ("supervisor", "robot", "controller", "guidance"):
            self.set_status("", topic)

    def set_status(
        self, text: str, topic: str = "controller", trouble: str = ""
    ):
        """Shows a line of text in the panel, one line for each topic.

        Args:
            text: Text of the line; an empty text removes the line.
            topic: Topic of the line, one of `page_style.TOPICS`.
            trouble: Problem that is highlighted at the end of the line.
        """
        self.status[topic] = f"{text} {trouble}".strip()
        self._notes[topic] = text, trouble
        lines = [
            (topic, *self._notes[topic])
            for topic in page_style.TOPICS
            if self.status.get(topic)
        ]
        self._newest.put(("notes",), lines)

    def set_badge(self, grade: str, title: str, text: str):
        """Shows a badge with the grade of the map.

        Args:
            grade: A grade of `map_grade`; it determines the colour.
            title: The grade, in a word or two.
            text: The reason for the grade.
        """
        badge = {"grade": grade, "title": title, "text": text}
        self._newest.put(("badge",), badge)

    def set_plot(self, name: str, svg: str):
        """Shows a plot in the panel.

        Args:
            name: Name of the plot. An earlier plot of this name is replaced.
            svg: An inline SVG.
        """
        self._newest.put(("plot", name), svg)

    def set_places(
        self, hand: np.ndarray, base: np.ndarray, target: np.ndarray | None
    ):
        """Sets the points at which the page's selectable views look.

        Args:
            hand: Position of the first end effector in W, shape (3,) [m].
            base: Position of the base in W, shape (3,) [m].
            target: Position of the hand's target in W, shape (3,) [m]; None for
                none.
        """
        named = {"hand": hand, "base": base, "target": target}
        places = {
            name: None if p_W is None else np.round(p_W, 4).tolist()
            for name, p_W in named.items()
        }
        self._newest.put(("places",), places)

    def set_legend(self, entries: Sequence[tuple[str, str]]):
        """Shows the meaning of the scene's colours.

        Args:
            entries: Colours as HTML colour codes, each with its meaning.
        """
        self._newest.put(("legend",), list(entries))

    def set_task(self, outline: TaskOutline, root: str):
        """Lists a task's steps and objects, and marks the present step.

        Args:
            outline: The task.
            root: Path in the scene below which the objects are drawn.
        """
        self._newest.put(("task",), {**outline.document(), "root": root})

    def set_account(self, account: Account):
        """Shows the summary of a run, and a player for its replay.

        Args:
            account: The summary of the run.
        """
        self._newest.put(("account",), account.document())

    def told(self, *key: str):
        """Returns the content that the page shows under a key; None if none.

        Args:
            *key: The key, as in `web/panel.js`, such as "badge".
        """
        return self._newest.get(key)

    def start_recording(self, start: float = 0.0):
        """Records all motion from now on, for replay in the page.

        Args:
            start: Time of the diagram at which the recording begins [s].
        """
        self.scene.record(start)

    def pause_recording(self):
        """Stops recording, for example to limit the memory that it takes."""
        self.scene.pause()

    def finish_recording(self):
        """Stops recording; the page and its saved copies can then replay it."""
        self.meshcat.SetProperty(
            LIVE, "visible", False, time_in_recording=self.scene.start
        )
        self.scene.pause()
        self.scene.settle()
        self.meshcat.PublishRecording()
        self.meshcat.SetProperty(LIVE, "visible", True)

    def save_html(self, path: str | Path, account: Account | None = None):
        """Writes the page as one file that needs neither server nor network.

        The file is compressed and written atomically. It contains a player with
        a time line, and the summary of the run in place of the texts about the
        running robot.

        Args:
            path: The HTML file.
            account: The summary of the run; None if the page shows a fixed
                scene.

        Raises:
            FileError: The file cannot be written.
        """
        path = Path(path)
        self.scene.settle()
        lasting = {
            topic: self._newest.get((topic,))
            for topic in ("bar", "badge", "scene", "legend", "task", "account")
        }
        if account is not None:
            lasting["bar"] = account.state.document()
            lasting["account"] = account.document()
        page = saved_page(self.meshcat.StaticHtml(), lasting)
        with atomic_write(path) as file:
            file.write(pack(page, path.stem))


def _start_server(port: int | None, host: str, newest: Newest) -> PageServer:
    """Opens the page's server on a port, or on the first free port.

    Raises:
        RemoSplatError: The port is taken or out of range.
    """
    if port is None:
        return _start_on_first_free_port(host, newest)
    if not 1024 <= port <= 65535:
        raise RemoSplatError(
            f"meshcat port {port} is out of range; valid: 1024 to 65535"
        )
    try:
        return PageServer(host, port, newest)
    except OSError as error:
        raise RemoSplatError(
            f"meshcat port {port} is taken on host {host!r};"
            " choose another port, or omit the flag to use the first free one"
        ) from error


def _start_on_first_free_port(host: str, newest: Newest) -> PageServer:
    """Opens the page's server on the first free port.

    Raises:
        RemoSplatError: No port is free, or there is no such interface.
    """
    for port in range(_FIRST_PORT, 65536):
        if is_free(host, port):
            # Another program can take the port after it was found free.
            with suppress(OSError):
                return PageServer(host, port, newest)
    raise RemoSplatError(f"no port is free on host {host!r}")


def _start_meshcat(host: str) -> Meshcat:
    try:
        return Meshcat(MeshcatParams(host=host, show_stats_plot=False))
    except RuntimeError as error:
        raise RemoSplatError(
            f"meshcat found no free port on host {host!r}"
        ) from error
