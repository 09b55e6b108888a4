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
"""Longest time for the start of the process [s]."""

PATIENCE = 5.0
"""Time without an answer after which the process counts as lost [s]."""

_NICENESS = 10
"""Nice value of the process, with which the control tick has precedence."""

_IN_USE = 2
"""Number of cores that the control loop, its page and its messages need."""

DIED = "the look-ahead process has died"

_log = logging.getLogger(__name__)


class LookAheadProcess:
    """A process that computes rollouts with a budget of wall-clock time.

    The process is spawned at low priority, and has a thread for each core that
    the control loop does not need. It receives each revision of the map once;
    all other messages are small. After its start, the control loop never waits
    for it: late answers are used at a later tick. If the process dies or fails,
    this is logged once, and `missing` contains the reason from then on. If it
    does not answer for a while, `missing` contains the reason until it answers
    again.

    Attributes:
        missing: Why there are no rollouts at present; empty if there are.
        process: The operating system's process.
        close: Ends the process; called at the latest when this object is
            deleted.
    """

    def __init__(
        self, rule: SelectionRule, budget: float, field: DistanceField
    ):
        """Starts the process and waits until it has loaded everything.

        The process rehearses planning, so that the first search is not slower
        than later ones.

        Args:
            rule: The guidances to try, and the condition of arrival. The
                process must be able to import the classes of all its parts,
                such as the law's ingredients; classes defined in a notebook
                cannot be imported.
            budget: Time that an answer may take [s].
            field: The map, or another one of the same kind.

        Raises:
            TransferError: A part of the rule, which the text names, cannot
                be sent to the process.
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
        # If it has already ended, its last message contains the reason.
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
        """Returns the process's latest answer, or else the present selection.

        Answers about another map or target are ignored. The present state is
        sent as soon as the previous one is answered, or at once if the map or
        the target is new: then the process aborts its present work.

        Args:
            selection: The present selection, which is returned if there is no
                new answer.
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
        # A map is larger than the pipe's buffer, so sending it waits for the
        # reader.
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
