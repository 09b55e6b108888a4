"""The program of the cockpit's process: it serves the page."""

import logging
import os
from multiprocessing.connection import Connection
from threading import Lock, RLock, Thread
from time import monotonic, sleep

import numpy as np
import viser

from remosplat_drake.base.array_pipe import ArrayHeader, receive_arrays
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.cockpit.authority import Authority
from remosplat_drake.cockpit.client_panel import ClientPanel
from remosplat_drake.cockpit.cockpit_plots import CockpitPlots
from remosplat_drake.cockpit.messages import (
    Beat,
    CockpitJob,
    CodeIssued,
    Failed,
    MapPicture,
    PageContent,
    Serving,
)
from remosplat_drake.cockpit.offers import (
    OfferSearch,
    Trouble,
    place_at_home,
)
from remosplat_drake.cockpit.operator_input import OperatorInput
from remosplat_drake.cockpit.operator_panel import OperatorPanel
from remosplat_drake.cockpit.pace import Pace
from remosplat_drake.cockpit.reach import (
    REACHABLE,
    UNSEEN_THERE,
    Reach,
    find_reach,
    is_within_reach,
)
from remosplat_drake.cockpit.robot_shapes import robot_shapes
from remosplat_drake.cockpit.scene import CockpitScene
from remosplat_drake.cockpit.surface_point import (
    clicked_object,
    find_surface,
    target_before,
)
from remosplat_drake.cockpit.web_server import open_server
from remosplat_drake.cockpit.wrist_monitor import WristMonitor
from remosplat_drake.cockpit.wrist_pictures import wrist_pictures
from remosplat_drake.oracle.object_field import ObjectField, with_objects
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.motion_status import NO_PATH
from remosplat_drake.signals.target import Target
from remosplat_drake.signals.thing import UNSEEN

_BEAT = 0.2
"""Time between two messages which state that the process is alive [s]."""

_LISTEN = 0.02
"""The page waits at most this long for a message of the control process [s]."""

_STANDOFF = 0.05
"""A proposed target is this far from the clicked surface, in addition to the
stopping distance [m]."""

_log = logging.getLogger(__name__)


def serve(connection: Connection, job: CockpitJob, picture: MapPicture) -> None:
    """Serves the page until the other end of the pipe is closed.

    Args:
        connection: Pipe to the control process. The page receives
            `PageContent`s and `MapPicture`s from it, and sends all other types
            of `messages`.
        job: The settings of the cockpit.
        picture: The map at the start.
    """
    try:
        page = Page(connection, job, picture)
    except (RemoSplatError, OSError) as error:
        connection.send(Failed(str(error)))
        return
    try:
        page.run()
    except (EOFError, ConnectionError):
        pass
    except Exception:
        _log.exception("the cockpit ends")
    finally:
        # This also ends the threads of the server and of the camera, which have
        # no work to finish.
        os._exit(0)


class Page:
    """The page of a cockpit, with all its viewers.

    Args:
        connection: Pipe to the control process.
        job: The settings of the cockpit.
        picture: The map at the start.

    Raises:
        OSError: The page cannot be served at the job's host and port.
    """

    def __init__(
        self, connection: Connection, job: CockpitJob, picture: MapPicture
    ):
        self._connection = connection
        self._sending = Lock()
        self._lock = RLock()
        self._job = job
        self._picture = picture
        self._content = _first_content(job)
        self._authority = Authority()
        self._panels: dict[int, ClientPanel] = {}
        self._inputs = OperatorInput(self._send)
        self._pace = Pace()
        self._asked: tuple[object, np.ndarray] | None = None
        self._latest: tuple[object, DistanceField] | None = None
        self._answered: Reach | None = None
        self._search = OfferSearch()
        self._looked_at: float | None = None
        self._server = open_server(job)
        gui = self._server.gui
        gui.configure_theme(
            show_logo=False, show_share_button=False, control_width="medium"
        )
        gui.set_panel_label(job.title)
        gui.main_panel.dock_right()
        self._shapes = robot_shapes(job.robot)
        self._scene = CockpitScene(self._server, job, self._shapes)
        self._scene.show_map(picture)
        self._scene.show(self._content)
        self._plots = CockpitPlots(self._server, job)
        self._server.on_client_connect(self._arrive)
        self._server.on_client_disconnect(self._leave)
        if job.make_camera is not None:
            Thread(target=self._show_pictures, daemon=True).start()

    def run(self) -> None:
        """Shows the messages from the pipe until the pipe is closed."""
        self._send(Serving(self._url()))
        self._send(CodeIssued(self._authority.code))
        Thread(target=self._keep_beating, daemon=True).start()
        while True:
            if self._connection.poll(_LISTEN):
                self._receive()
            self._answer_operator()
            self._offer()
            self._inputs.expire()

    def _keep_beating(self) -> None:
        """Reports periodically from STOP's event loop that STOP works."""
        loop = self._server.get_event_loop()
        while True:
            loop.call_soon_threadsafe(self._send, Beat())
            sleep(_BEAT)

    def _url(self) -> str:
        host = self._server.get_host()
        name = "localhost" if host in ("127.0.0.1", "0.0.0.0") else host
        return f"http://{name}:{self._server.get_port()}"

    def _send(self, message: object) -> None:
        with self._sending:
            try:
                self._connection.send(message)
            except OSError:
                os._exit(0)  # The control process has gone.

    def _receive(self) -> None:
        """Reads all messages that have arrived; shows the newest content."""
        content = None
        while self._connection.poll():
            message = self._connection.recv()
            if isinstance(message, ArrayHeader):
                self._picture = receive_arrays(self._connection, message)
                # This runs without the lock, since it takes long and STOP must
                # work during this time.
                self._scene.show_map(self._picture)
            else:
                content = message
                self._plots.add(content)
        if content is not None:
            self._looked_at = monotonic()
            self._pace.add(content.time, self._looked_at)
            with self._lock:
                self._content = content
                self._scene.show(content)
                for panel in self._panels.values():
                    panel.show(content, self._pace.share)
            self._plots.draw()

    def _arrive(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self._panels[client.client_id] = ClientPanel(
                client, self, self._content, self._scene.shows_unseen
            )

    def _leave(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self._panels.pop(client.client_id, None)
            if self._authority.leave(client.client_id):
                # No operator watches the robot any more.
                self._inputs.let_go()
                why = "the operator has left"
                self._send(CodeIssued(self._authority.code, why))

    def stop(self) -> None:
        """Stops the robot; every client may do so."""
        self._inputs.stop()

    def show_unseen(self, shown: bool) -> None:
        """Draws or hides the boundary of unseen space, for all clients."""
        with self._lock:
            self._scene.shows_unseen = shown

    def age(self) -> float:
        """Returns the age of the page's content [s]; 0 before a run."""
        return 0.0 if self._looked_at is None else monotonic() - self._looked_at

    def admit(self, panel: ClientPanel, code: str) -> str:
        """Lets a client operate.

        Args:
            panel: The client's panel.
            code: The typed text.

        Returns:
            Reason of a refusal; empty if the client operates from now on.
        """
        with self._lock:
            client = panel.client
            refusal = self._authority.admit(client.client_id, code)
            if refusal or panel.operator is not None:
                return refusal
            operator = OperatorPanel(
                client,
                self._job,
                self._inputs,
                self._content,
                self._shapes,
                lambda: self._hand_over(panel),
            )
            panel.operate(operator)

            @client.scene.on_click()
            def _(event: viser.SceneClickEvent):
                if panel.operator is operator:
                    self._propose(operator, event)

            return ""

    def _hand_over(self, panel: ClientPanel) -> None:
        with self._lock:
            if self._authority.leave(panel.client.client_id):
                panel.retire()
                self._inputs.let_go()
                why = "the operator has handed over"
                self._send(CodeIssued(self._authority.code, why))

    def _propose(
        self, operator: OperatorPanel, event: viser.SceneClickEvent
    ) -> None:
        """Proposes a target in front of a clicked point.

        If the point is on an object, the object is chosen, too. Else the point
        is chosen, at which an object may be found.
        """
        objects, clicked = self._content.objects, None
        ray = np.array(event.ray_origin), np.array(event.ray_direction)
        if objects:
            clicked = clicked_object(self._picture.field, objects, *ray)
        if clicked is not None:
            operator.point_at(*clicked)
        surfaces = self._field().surfaces
        if surfaces is None:
            return
        surface = find_surface(surfaces, *ray)
        if surface is not None:
            if clicked is None:
                operator.point_at_map(surface.p_W)
            standoff = self._job.stopping + _STANDOFF
            operator.propose(
                target_before(surface, self._content.X_WE, standoff)
            )

    def _field(self) -> DistanceField:
        """Returns the map, with the objects at their present poses."""
        content, scene = self._content, self._picture.field
        if not content.objects:
            return scene
        carried = {x.name for x in content.outline.objects if x.is_carried}
        standing = ObjectField(
            [each for each in content.objects if each.name not in carried]
        )
        key = scene, standing.revision
        if self._latest is None or self._latest[0] != key:
            self._latest = key, with_objects(scene, standing)
        return self._latest[1]

    def _answer_operator(self) -> None:
        """Tests whether the operator's target can be reached, if it is new."""
        with self._lock:
            operator = self._operator
            if operator is None:
                return
            X_WT, field = operator.question, self._field()
        if X_WT is None:
            if self._asked is not None:
                self._asked = self._answered = None
                operator.withdraw()
            return
        if self._asked is not None:
            asked_in, asked = self._asked
            if asked_in is field and np.array_equal(asked, X_WT):
                return
        self._asked = field, X_WT
        self._answered = self._reach(X_WT)
        operator.answer(self._answered, X_WT)

    def _offer(self) -> None:
        """Searches for other targets if the robot cannot reach its target."""
        with self._lock:
            operator, field = self._operator, self._field()
        if operator is None:
            return
        self._search.begin(self._trouble(operator), field)
        self._search.step(self._is_within_reach)
        operator.offer(self._search.offers)

    def _trouble(self, operator: OperatorPanel) -> Trouble | None:
        """The situation for which alternative targets are searched, or None."""
        content, reach = self._content, self._answered
        p_W = None
        if reach is not None and reach.verdict != REACHABLE:
            p_W = reach.p_W if reach.verdict == UNSEEN_THERE else None
        elif content.cause and not operator.proposes:
            p_W = content.p_WHeld if content.cause == UNSEEN else None
        else:
            return None
        X_WT = content.X_WT if operator.question is None else operator.question
        p_WHome = place_at_home(self._job.robot, content.q, content.effector)
        is_cut_off = content.cause == NO_PATH
        return Trouble(
            X_WT, content.X_WE, p_WHome, p_W, self._job.X_EC, is_cut_off
        )

    @property
    def _operator(self) -> OperatorPanel | None:
        number = self._authority.operator
        panel = None if number is None else self._panels.get(number)
        return None if panel is None else panel.operator

    def _reach(self, X_WT: np.ndarray) -> Reach:
        return find_reach(*self._question(X_WT))

    def _is_within_reach(self, X_WT: np.ndarray) -> bool:
        return is_within_reach(*self._question(X_WT))

    def _question(self, X_WT: np.ndarray) -> tuple:
        """Returns the arguments of `find_reach` for a target."""
        job, field, content = self._job, self._field(), self._content
        targets: list[Target | None] = [None] * len(job.robot.effectors)
        if content.X_WTs is not None:  # The other hands are held.
            targets = [Target(X) for X in content.X_WTs]
        targets[content.effector] = Target(X_WT).without(*job.config.free)
        aim = Aim(tuple(targets))
        return job.planner, field, job.stopping, content.q, aim

    def _show_pictures(self) -> None:
        """Shows the wrist camera's image, in a separate thread."""

        def now() -> tuple[PageContent, int]:
            return self._content, self._inputs.requests.scene_changes

        monitor = WristMonitor(self._server)
        try:
            for frame in wrist_pictures(self._job, now):
                with self._lock:
                    self._scene.show_camera(frame.X_WC, frame.K, frame.rgb)
                    monitor.show(frame)
        except RemoSplatError as error:
            _log.warning("no pictures of the wrist camera: %s", error)


def _first_content(job: CockpitJob) -> PageContent:
    state = job.robot.state(job.q0)
    return PageContent(0.0, job.q0, state.X_WE, state.X_WB, state.X_WE)
