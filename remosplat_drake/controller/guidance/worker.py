"""Computes rollouts inside the look-ahead process.

The process receives each new version of the map, and the robot's states. It
responds to each state within a budget of wall-clock time. The response contains
the selection, if the selection has changed since the previous response.
"""

import dataclasses as dc
from collections.abc import Callable
from multiprocessing.connection import Connection
from time import perf_counter

from remosplat_drake.base.array_pipe import (
    ArrayHeader,
    receive_arrays,
)
from remosplat_drake.controller.guidance.present_state import PresentState
from remosplat_drake.controller.guidance.rollout import (
    RUNNING,
    STRIDE,
)
from remosplat_drake.controller.guidance.rule_transfer import (
    PackedRule,
    TransferError,
    unpack_rule,
)
from remosplat_drake.controller.guidance.selection import (
    Selection,
    start_selection,
)
from remosplat_drake.controller.guidance.selection_round import (
    advance_selection,
)
from remosplat_drake.controller.guidance.selection_rule import SelectionRule
from remosplat_drake.controller.planning.rehearsal import rehearse
from remosplat_drake.controller.tick.tick_calls import asks_python
from remosplat_drake.signals.distance_field import DistanceField

READY = "ready"
"""Message in which the process states that it has loaded all kernels."""


@dc.dataclass(frozen=True)
class Failure:
    """Message in which the process states that it ends because of a failure.

    Attributes:
        reason: Reason of the failure, for display.
    """

    reason: str


def serve(
    connection: Connection, packed: PackedRule, budget: float, threads: int
) -> None:
    """Responds to states, in the look-ahead process, until the pipe is closed.

    Args:
        connection: The process's end of a pipe. The process receives maps, by
            `base.array_pipe`, and `PresentState`s. With the first map, it plans
            a short path to load all kernels; then it sends READY. It receives
            the second map before the first state. Its response to a state is a
            `Selection`, or None if the previous selection is still valid. Its
            last message may be a `Failure` or a `TransferError`.
        packed: The selection rule, packed by `pack_rule`.
        budget: Time that a response may take [s].
        threads: Number of rollouts that may be simulated in parallel.
    """
    try:
        _answer(connection, unpack_rule(packed), budget, threads)
    except (EOFError, ConnectionError):
        return
    except TransferError as error:
        connection.send(error)
    except Exception as error:
        connection.send(Failure(f"{type(error).__name__}: {error}"))


def _answer(
    connection: Connection, rule: SelectionRule, budget: float, threads: int
) -> None:
    field = receive_arrays(connection, connection.recv())
    if rule.motions is not None:
        rehearse(rule.motions, rule.motions.robot.q_home, field)
    connection.send(READY)
    selection, field = start_selection(rule), None
    while True:
        message = connection.recv()
        if isinstance(message, ArrayHeader):
            field = receive_arrays(connection, message)
            continue
        assert field is not None
        following = look_ahead(
            rule,
            selection,
            message,
            field,
            perf_counter() + budget,
            connection.poll,
            threads,
        )
        connection.send(_news(selection, following))
        selection = following


def look_ahead(
    rule: SelectionRule,
    selection: Selection,
    now: PresentState,
    field: DistanceField,
    until: float,
    interrupted: Callable[[], bool],
    threads: int = 1,
) -> Selection:
    """Advances a selection until it is complete, or until a given time.

    Args:
        rule: The selector's settings.
        selection: The selection so far.
        now: The robot's present state.
        field: The map.
        until: Time at which to end, by `perf_counter` [s].
        interrupted: Function that returns whether to abort. It is called once
            every few steps.
        threads: Number of rollouts that may be simulated in parallel.
    """
    while perf_counter() < until and not interrupted():
        following = advance_selection(
            rule,
            selection,
            field=field,
            budget=_at_once(rule, selection, field, threads),
            interrupted=interrupted,
            threads=threads,
            **vars(now),
        )
        if following is selection:
            break
        selection = following
    return selection


def _at_once(
    rule: SelectionRule,
    selection: Selection,
    field: DistanceField,
    threads: int,
) -> int:
    """Returns the number of rollout steps between two checks of the time."""
    if asks_python(rule.law, field):
        return 1
    running = [r for r in selection.running if r.status == RUNNING]
    return STRIDE * max(1, min(threads, len(running)))


def _news(before: Selection, after: Selection) -> Selection | None:
    """Returns the selection without unneeded parts; None if it is not new."""
    if (
        after.guidance is before.guidance
        and after.latest is before.latest
        and after.revision == before.revision
        and after.aim is before.aim
    ):
        return None
    return dc.replace(after, running=(), waiting=(), finished=())
