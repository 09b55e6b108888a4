"""Merges the commands of several operators: the newest request is used."""

import dataclasses as dc
from collections.abc import Sequence

from remosplat_drake.signals.operator_command import OperatorCommand

_LEADING = (
    "moves",
    "holds",
    "homes",
    "poses",
    "scans",
    "choices",
    "takes",
    "places",
    "finds",
)
"""Fields of `OperatorCommand` that count requests about the target. An operator
who makes such a request leads from then on."""

_COUNTS = (*_LEADING, "opens", "closes")
"""All fields that count requests. Opening or closing the hand does not change
the leader, since it does not move the target."""

_VALUES = {
    "poses": ("pose",),
    "choices": ("effector",),
    "takes": ("thing",),
    "places": ("support", "p_WNear"),
    "finds": ("p_WFind",),
}
"""Fields that count requests, each with the fields that contain the values of
the latest request."""


@dc.dataclass(frozen=True, eq=False)
class MergedCommand:
    """Merged commands of several operators; a deep copy is the object itself.

    Attributes:
        sources: The command of each operator.
        leader: Index of the operator whose pose or velocity moves the target.
        command: The merged command.
    """

    sources: tuple[OperatorCommand, ...]
    leader: int = 0
    command: OperatorCommand = dc.field(default_factory=OperatorCommand)

    @staticmethod
    def silent(count: int) -> "MergedCommand":
        """Returns the state of operators that have not made a request."""
        return MergedCommand((OperatorCommand(),) * count)

    def __deepcopy__(self, memo) -> "MergedCommand":
        return self


def merge_commands(
    before: MergedCommand, sources: Sequence[OperatorCommand]
) -> MergedCommand:
    """Merges the commands of several operators.

    An operator with a new request leads from then on: its pose, velocity and
    trouble are used, and those of the other operators are ignored. If two
    operators make requests at the same time, the first one leads. Button
    presses of all operators count.

    Args:
        before: The result of the previous call.
        sources: The command of each operator now, in the same order.
    """
    pairs = list(zip(before.sources, sources, strict=True))
    new = [i for i, pair in enumerate(pairs) if _wishes_anew(*pair)]
    leader = new[0] if new else before.leader
    counts = {
        name: sum(getattr(source, name) for source in sources)
        for name in _COUNTS
    }
    command = dc.replace(sources[leader], **counts)
    for count, names in _VALUES.items():
        source = next(
            (now for known, now in pairs if _more(known, now, count)),
            before.command,
        )
        values = {name: getattr(source, name) for name in names}
        command = dc.replace(command, **values)
    return MergedCommand(tuple(sources), leader, command)


def _wishes_anew(known: OperatorCommand, now: OperatorCommand) -> bool:
    pressed = known.V_W is None and now.V_W is not None
    return pressed or any(_more(known, now, name) for name in _LEADING)


def _more(known: OperatorCommand, now: OperatorCommand, count: str) -> bool:
    return getattr(now, count) > getattr(known, count)
