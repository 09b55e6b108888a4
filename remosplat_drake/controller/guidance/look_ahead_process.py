"""`LookAheadProcess`: computes rollouts in a separate process."""

import logging
import weakref
from contextlib import suppress
from multiprocessing.connection import Connection
from threading import Thread
from time import perf_counter

from remosplat_drake.base.array_pipe import send_arrays
from remosplat_drake.base.child_process import ChildProcess
from remosplat_drake.base.threads import num_threads
from remosplat_drake.controller.guidance.present_state import PresentState
from remosplat_drake.controller.guidance.rule_transfer import (
    TransferError,
    pack_rule,
)
from remosplat_drake.controller.guidance.selection import Selection
from remosplat_drake.controller.guidance.selection_rule import SelectionRule
from remosplat_drake.controller.guidance.worker import Failure, serve
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField

START_TIME = 60.0
"""Longest time that the start of the process may take [s]."""

PATIENCE = 5.0
"""If the process sends no response for this time, it counts as lost [s]."""

_NICENESS = 10
"""Nice value of the process, so that the control tick takes precedence."""

_IN_USE = 2
"""The process leaves this many cores to the control loop, the web page and the
communication."""

DIED = "the look-ahead process has died"

_log = logging.getLogger(__name__)


class LookAheadProcess:
    """A process that computes rollouts within a budget of wall-clock time.

    The process is spawned at low priority, and has a thread for each core that
    the control loop does not need. It receives each revision of the map once;
    all other messages are small. After the start of the process, the control
    loop does not wait for it, and uses a late response at a later tick. If the
    process dies or fails, this is logged once, and from then on `missing`
    contains the reason. If the process does not respond for some time,
    `missing` contains the reason until the process responds again.

    Attributes:
        missing: Reason why no rollouts are computed at present; empty if they
            are.
        process: The process of the operating system.
        close: Function that ends the process. It is called when this object is
            deleted, if not before.
    """

    def __init__(
        self, rule: SelectionRule, budget: float, field: DistanceField
    ):
        """Starts the process, and waits until it has loaded all kernels.

        The process first plans a short path, so that the first search for a
        path is not slower than later searches.

        Args:
            rule: The selector's settings. The process must be able to import
                the classes of all its parts, such as the ingredients of the
                control law. Classes that are defined in a notebook cannot be
                imported.
            budget: Time that a response may take [s].
            field: The map, or another map of the same kind.

        Raises:
            TransferError: A part of the rule cannot be sent to the process. The
                error names the part.
        """
        packed = pack_rule(rule)
        self._child = ChildProcess(serve, "look-ahead", _NICENESS)
        self._child.start(packed, budget, max(1, num_threads() - _IN_USE))
        self._connection, self.process = self._child.wait_until_started()
        self.missing = ""
        self._lost = False
        self._sender: Thread | None = None
        self._unanswered = 0
        self._asked_at = 0.0
        self._sent: tuple[str, Aim] | None = None
        self.close = weakref.finalize(self, self._child.end, patience=0.5)
        self._wait_until_ready(field)

    def _wait_until_ready(self, field: DistanceField) -> None:
        # If the process has already ended, its last message contains the
        # reason.
        with suppress(OSError):
            send_arrays(self._connection, field)
        try:
            ready = self._connection.poll(START_TIME)
            message = self._connection.recv() if ready else Failure("no answer")
        except (EOFError, OSError):
            message = Failure(DIED)
        if isinstance(message, TransferError):
            self.close()
            raise message
        if isinstance(message, Failure):
            self._give_up(f"look-ahead has not started: {message.reason}")

    def update(
        self, selection: Selection, now: PresentState, field: DistanceField
    ) -> Selection:
        """Returns the latest response of the process, or `selection`.

        A response is ignored if it belongs to another map or target. The
        present state is sent to the process as soon as it has responded to the
        previous state. If the map or the target is new, the state is sent at
        once, and the process aborts its present work.

        Args:
            selection: The present selection, which is returned if there is no
                new response.
            now: The robot's present state.
            field: The map.
        """
        if self._lost or self._is_sending():
            return selection
        try:
            selection = self._received(selection, now, field)
            if not self.missing:
                self._send(now, field)
        except (EOFError, OSError):
            self._give_up(DIED)
        return selection

    def _is_sending(self) -> bool:
        return self._sender is not None and self._sender.is_alive()

    def _received(
        self, selection: Selection, now: PresentState, field: DistanceField
    ) -> Selection:
        while self._connection.poll():
            message = self._connection.recv()
            if isinstance(message, Failure):
                self._give_up(f"look-ahead failed: {message.reason}")
                return selection
            self._unanswered -= 1
            self.missing = ""
            if message is not None and _is_about(message, now, field):
                selection = message
        late = perf_counter() - self._asked_at > PATIENCE
        if self._unanswered and late and not self.missing:
            self.missing = f"look-ahead has not answered for {PATIENCE:g} s"
            _log.warning("%s; continuing without until then", self.missing)
        return selection

    def _send(self, now: PresentState, field: DistanceField) -> None:
        known = self._sent
        new_map = known is None or known[0] != field.revision
        new_target = known is None or not known[1].equals(now.aim)
        if self._unanswered and not (new_map or new_target):
            return
        self._sent = field.revision, now.aim
        self._unanswered += 1
        self._asked_at = perf_counter()
        if not new_map:
            self._connection.send(now)
            return
        # A map is larger than the pipe's buffer, so sending a map waits until
        # the process reads it.
        self._sender = Thread(
            target=_send_both, args=(self._connection, field, now), daemon=True
        )
        self._sender.start()

    def _give_up(self, reason: str) -> None:
        self.missing, self._lost = reason, True
        _log.warning("%s; continuing without", reason)
        self._child.end(patience=0.0)


def _is_about(
    selection: Selection, now: PresentState, field: DistanceField
) -> bool:
    aim = selection.aim
    is_same = aim is not None and aim.equals(now.aim)
    return is_same and selection.revision == field.revision


def _send_both(
    connection: Connection, field: DistanceField, now: PresentState
) -> None:
    try:
        send_arrays(connection, field)
        connection.send(now)
    except OSError:
        return  # The process has died; the next `update` handles this.
