"""Merges the commands of several operators: the newest request counts."""

import dataclasses as dc
from collections.abc import Sequence

from remosplat_drake.signals.operator_command import OperatorCommand

_LEADING = ("moves", "holds", "homes", "poses", "scans", "choices")
"""Fields of `OperatorCommand` that count requests about the target. An operator
who makes such a request leads from then on."""

_COUNTS = (*_LEADING, "opens", "closes")
"""All fields that count requests. Opening or closing the hand does not change
the leader, since it does not move the target."""


@dc.dataclass(frozen=True, eq=False)
class MergedCommand:
    """Several operators together; copying returns the object itself.

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
        """Returns operators without a request so far."""
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
    picks = [now.pose for known, now in pairs if now.poses > known.poses]
    chosen = [x.effector for known, x in pairs if x.choices > known.choices]
    counts = {
        name: sum(getattr(source, name) for source in sources)
        for name in _COUNTS
    }
    command = dc.replace(
        sources[leader],
        pose=picks[0] if picks else before.command.pose,
        effector=chosen[0] if chosen else before.command.effector,
        **counts,
    )
    return MergedCommand(tuple(sources), leader, command)


def _wishes_anew(known: OperatorCommand, now: OperatorCommand) -> bool:
    pressed = known.V_W is None and now.V_W is not None
    counted = any(getattr(now, n) > getattr(known, n) for n in _LEADING)
    return pressed or counted
