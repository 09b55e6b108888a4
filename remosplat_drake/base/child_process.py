"""`ChildProcess`: a spawned process that does not slow the control loop."""

import logging
import multiprocessing
import os
import select
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from threading import Lock, Thread
from time import sleep

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
    "LP_NUM_THREADS": "1",
}
"""Environment variables that keep a child process to one thread.

`LP_NUM_THREADS` is that of Mesa's software renderer llvmpipe.
"""


class _Inside:
    """Number of active `one_thread_environment` blocks.

    Attributes:
        lock: Held while the environment is changed.
        count: Number of active blocks.
    """

    def __init__(self):
        self.lock = Lock()
        self.count = 0


_inside = _Inside()


@contextmanager
def one_thread_environment() -> Iterator[None]:
    """Sets `ONE_THREAD` for child processes that the block starts.

    Numerical libraries read the variables when they load. Only the environment
    of the C library changes, which children inherit. `os.environ` of this
    process stays as it is, because Numba reads it at each compilation and fails
    if the number of threads has changed. Blocks of several threads may overlap.
    """
    with _inside.lock:
        _inside.count += 1
        for name, value in ONE_THREAD.items():
            os.putenv(name, value)
    try:
        yield
    finally:
        with _inside.lock:
            _inside.count -= 1
            if not _inside.count:
                _restore()


def _restore() -> None:
    for name in ONE_THREAD:
        value = os.environ.get(name)
        if value is None:
            os.unsetenv(name)
        else:
            os.putenv(name, value)


class ChildProcess:
    """A daemon process with a pipe, started by multiprocessing's spawn.

    Its numerical libraries use one thread. Its scheduling policy is
    SCHED_OTHER, independent of the starting thread; it may be niced, and
    ignores Ctrl-C (SIGINT), which its parent handles. Its target must return
    when the pipe is closed (EOFError).

    Attributes:
        connection: The parent's end of the pipe; None while no process runs or
            one is still starting.
        process: The process; None in the same cases.
    """

    def __init__(self, target: Callable[..., None], name: str, niceness: int):
        """Prepares a process; `start` starts it.

        Args:
            target: A module-level function that runs in the process. Its
                first argument is the child's end of the pipe.
            name: Name of the process, for display.
            niceness: Increment of its nice value, 0 to 19.
        """
        self._target = target
        self._name = name
        self._niceness = niceness
        self.connection: Connection | None = None
        self.process: BaseProcess | None = None
        self._poll = select.poll()
        self._starter: Thread | None = None

    @property
    def is_down(self) -> bool:
        """Whether no process runs or is starting."""
        return self._starter is None

    def start(self, *arguments: object) -> None:
        """Starts the process from a background thread, since spawning is slow.

        Args:
            arguments: The target's arguments after the pipe; each is pickled.
        """
        self._starter = Thread(target=self._spawn, args=arguments)
        self._starter.start()

    def wait_until_started(self) -> tuple[Connection, BaseProcess]:
        """Waits until `start` has made the process and its pipe.

        Returns:
            The parent's end of the pipe, and the process.

        Raises:
            RuntimeError: The process cannot be started; a traceback says why.
        """
        if self._starter is not None:
            self._starter.join()
        if self.connection is None or self.process is None:
            raise RuntimeError(f"the process {self._name!r} has not started")
        return self.connection, self.process

    def _spawn(self, *arguments: object) -> None:
        # Starting the resource tracker unblocks SIGINT, so it is started first.
        # The process inherits the settings below: SIGINT is blocked from its
        # start, and it has no real-time priority even if the control loop has
        # one.
        resource_tracker.ensure_running()
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        spawn = multiprocessing.get_context("spawn")
        connection, theirs = spawn.Pipe()
        process = spawn.Process(
            target=_run,
            args=(self._target, theirs, self._niceness, *arguments),
            name=self._name,
            daemon=True,
        )
        try:
            with one_thread_environment():
                process.start()
            self.process = process
        finally:
            # Without a process, the first read finds the other end closed.
            theirs.close()
            self._poll.register(connection.fileno(), select.POLLIN)
            self.connection = connection

    def has_news(self) -> bool:
        """Whether a message, or the end of the pipe, can be read at once."""
        return bool(self._poll.poll(0))

    def wait(self, timeout: float) -> None:
        """Waits for a message or the end of the pipe.

        Args:
            timeout: The longest wait [s].
        """
        if self.connection is None:
            sleep(timeout)
        else:
            self._poll.poll(1e3 * timeout)

    def end(self, patience: float = 2.0) -> None:
        """Closes the pipe, which ends the process, and waits for its exit.

        Does nothing if no process runs. `start` may then start another one.

        Args:
            patience: Time after which the process is killed [s].
        """
        if self._starter is not None:
            self._starter.join()
            self._starter = None
        if self.connection is not None:
            self._poll.unregister(self.connection.fileno())
            self.connection.close()
            self.connection = None
        if self.process is not None:
            self.process.join(patience)
            if self.process.is_alive():
                self.process.kill()
                self.process.join()
            self.process = None


def _run(
    target: Callable[..., None],
    connection: Connection,
    niceness: int,
    *arguments: object,
) -> None:
    """Sets up the process and runs its target."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.getLogger("drake").setLevel(logging.WARNING)
    os.nice(niceness)
    target(connection, *arguments)
