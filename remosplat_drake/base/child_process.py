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
"""Environment variables that limit numerical libraries to one thread.

`LP_NUM_THREADS` is the variable of Mesa's software renderer llvmpipe.
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
    """Limits the child processes that the block starts to one thread.

    The function sets the variables `ONE_THREAD`, which numerical libraries read
    when they are loaded. It sets them only in the environment of the C library,
    which child processes inherit. It does not change `os.environ`, because
    Numba reads `os.environ` at each compilation and fails if the number of
    threads has changed. Several threads may be inside such a block at the same
    time.
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

    The process ignores Ctrl-C (SIGINT), which its parent handles. Its numerical
    libraries use one thread. Its scheduling policy is SCHED_OTHER, even if the
    thread that starts it has a real-time priority. The function that runs in
    the process must return when reading the pipe raises an EOFError, which
    means that the pipe is closed.

    Attributes:
        connection: The parent's end of the pipe; None if no process runs, or
            while the process is starting.
        process: The process; None if no process runs, or while the process is
            starting.
    """

    def __init__(self, target: Callable[..., None], name: str, niceness: int):
        """Prepares a process; `start` starts it.

        Args:
            target: A module-level function that runs in the process. Its
                first argument is the child's end of the pipe.
            name: Name of the process in messages.
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
        """Whether no process runs or starts."""
        return self._starter is None

    def start(self, *arguments: object) -> None:
        """Starts the process on a background thread, because spawning is slow.

        Args:
            arguments: The arguments of the target after its first one, the
                pipe. Each is pickled.
        """
        self._starter = Thread(target=self._spawn, args=arguments)
        self._starter.start()

    def wait_until_started(self) -> tuple[Connection, BaseProcess]:
        """Waits until `start` has made the process and its pipe.

        Returns:
            The parent's end of the pipe, and the process.

        Raises:
            RuntimeError: The process cannot be started; a traceback on stderr
                states the reason.
        """
        if self._starter is not None:
            self._starter.join()
        if self.connection is None or self.process is None:
            raise RuntimeError(
                f"the process {self._name!r} could not be "
                "started; see the traceback above"
            )
        return self.connection, self.process

    def _spawn(self, *arguments: object) -> None:
        # The new process inherits the settings below: it blocks SIGINT, and has
        # no real-time priority, even if the control loop has one. Python's
        # resource tracker is started first, since starting it unblocks SIGINT.
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
            # If no process has started, the first read raises EOFError, since
            # the other end is closed.
            theirs.close()
            self._poll.register(connection.fileno(), select.POLLIN)
            self.connection = connection

    def has_news(self) -> bool:
        """Whether a message has arrived or the pipe is closed."""
        return bool(self._poll.poll(0))

    def wait(self, timeout: float) -> None:
        """Waits until a message has arrived or the pipe is closed.

        Args:
            timeout: The method returns after this time at the latest [s].
        """
        if self.connection is None:
            sleep(timeout)
        else:
            self._poll.poll(1e3 * timeout)

    def end(self, patience: float = 2.0) -> None:
        """Ends the process by closing its pipe, and waits for its exit.

        If no process runs, nothing happens. Afterwards, `start` may start
        another process.

        Args:
            patience: Time after which the process is killed if it has not
                exited [s].
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
