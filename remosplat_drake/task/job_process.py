"""`JobProcess`: searches for the steps of jobs in a separate process."""

import logging
import weakref
from multiprocessing.connection import Connection
from threading import Lock, Thread

from remosplat_drake.base.array_pipe import receive_arrays, send_arrays
from remosplat_drake.base.child_process import ChildProcess
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.task.job_maker import JobMaker
from remosplat_drake.task.job_search import FoundJob, JobRequest, search_job

DIED = (
    "the process that searches grasps and places has ended; request the job "
    "again"
)

DEAD = FoundJob(problem=DIED)
"""The answer if the process has ended."""

_NICENESS = 10
"""Nice value of the process. It gives the control tick precedence."""

_log = logging.getLogger(__name__)


class JobProcess:
    """A process that searches for the steps of jobs; a `JobSearch`.

    A search takes seconds, so a real robot's ticks must not wait for it. The
    process receives each version of the map once. If the process dies, the
    present search fails, and the next request starts a new process. The process
    finishes a cancelled search before it begins the next search.

    Args:
        maker: The `JobMaker`, which makes the steps. The process has a copy of
            it.

    Attributes:
        close: Function that ends the process. It is called, at the latest, when
            this object is deleted.
    """

    def __init__(self, maker: JobMaker):
        self._maker = maker
        self._child = ChildProcess(_serve, "job search", _NICENESS)
        self._pipe = _Pipe(self._child, maker)
        self._request: JobRequest | None = None
        self._number = 0
        self.close = weakref.finalize(self, self._child.end, patience=0.0)

    def start(self) -> None:
        """Starts the process in the background, so that it is ready early."""
        self._pipe = _Pipe(self._child, self._maker)
        self._child.start()
        Thread(target=self._pipe.prepare, daemon=True).start()

    def __call__(
        self, request: JobRequest, scene: DistanceField
    ) -> FoundJob | None:
        """Returns the steps of a job; None while the process searches.

        Args:
            request: The job.
            scene: The map without the objects.
        """
        if request is not self._request:
            if self._child.is_down:
                self.start()
            self._request, self._number = request, self._number + 1
            Thread(
                target=self._pipe.ask,
                args=(self._number, request, scene),
                daemon=True,
            ).start()
            return None
        found = self._pipe.answers.pop(self._number, None)
        if found is DEAD:
            _log.warning(DIED)
            self._child.end(patience=0.0)
        return found


class _Pipe:
    """Asks the process from threads, since a large map takes long.

    Attributes:
        answers: The answers that were not yet read, by the request's number.
    """

    def __init__(self, child: ChildProcess, maker: JobMaker):
        self._child, self._maker = child, maker
        self._lock = Lock()
        self._is_prepared = False
        self._scene = ""
        self.answers: dict[int, FoundJob] = {}

    def prepare(self) -> None:
        """Sends the maker, which is the first message."""
        with self._lock:
            self._prepare()

    def ask(
        self, number: int, request: JobRequest, scene: DistanceField
    ) -> None:
        """Sends a request, with the map if it has changed, and the answer."""
        with self._lock:
            try:
                self._prepare()
                is_new = scene.revision != self._scene
                self._scene = scene.revision
                self._send((request, scene if is_new else None))
                connection, _ = self._child.wait_until_started()
                found = receive_arrays(connection, connection.recv())
            except (EOFError, OSError, RuntimeError):
                found = DEAD
            self.answers[number] = found

    def _prepare(self) -> None:
        if not self._is_prepared:
            self._is_prepared = True
            self._send(self._maker)

    def _send(self, value: object) -> None:
        try:
            connection, _ = self._child.wait_until_started()
            send_arrays(connection, value)
        except (OSError, RuntimeError):
            return  # The process has died; the next tick handles this.


def _serve(connection: Connection) -> None:
    """Runs in the process until the other end is closed.

    Args:
        connection: The process's end of the pipe. It receives a `JobMaker`, and
            then pairs of a request and a map, by `base.array_pipe`. The map is
            None if it has not changed. It answers with `FoundJob`s in the same
            way.
    """
    try:
        maker = receive_arrays(connection, connection.recv())
        while True:
            request, changed = receive_arrays(connection, connection.recv())
            scene = maker.scene if changed is None else changed
            send_arrays(connection, search_job(maker, request, scene))
    except (EOFError, ConnectionError):
        return
