"""`Selection`: the state of the selection of guidance."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.guidance.rollout import Rollout
from remosplat_drake.controller.guidance.selection_rule import SelectionRule
from remosplat_drake.controller.guidance.standing_movers import NOTHING
from remosplat_drake.controller.planning.plan import (
    NO_EFFORT,
    Plan,
    SearchEffort,
)
from remosplat_drake.controller.planning.roadmap import NO_ROADMAP, Roadmap
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.aim import Aim


@dc.dataclass(frozen=True, eq=False)
class Selection:
    """The state of the selector; copying returns the object itself.

    Attributes:
        guidance: The guidance to follow now.
        reason: Why this guidance is followed, for display.
        running: The present group of rollouts, which began together, including
            ended ones; empty between rounds.
        waiting: Candidates of the present round that have not been tried yet, a
            tuple for each tier.
        plans: Results of the path searches of the present round, one for each
            stopping distance that was tried.
        failures: Number of consecutive rounds with searches in which no
            candidate arrives.
        unreachable: Why no path to the target was found, for display; empty if
            one was found or none was searched.
        lack: The kind of that search's failure, see `Plan.lack`; empty if
            `unreachable` is.
        effort: Effort of all searches since the start of the run.
        found: Corners of the paths found to the present target on the present
            map.
        roadmap: Corners of the paths found earlier.
        around: Standing movers that were obstacles in the latest path search.
        finished: Rollouts of the earlier groups of the present round, first the
            one with the followed guidance.
        latest: Rollouts of the latest complete round.
        idle_until: Time before which nothing is computed [s]; see also
            `hopeless_at`.
        hopeless_at: Configuration at which the latest round ended without an
            arrival, shape (n_q,), else None. Once the robot has moved away from
            it, the next round starts even before `idle_until`.
        revision: Revision of the map of the round.
        aim: The aim of the round.
        missing: Why nothing is simulated although it should be, for display;
            empty if rollouts work.
        seconds: Wall-clock time of the latest update [s].
    """

    guidance: Guidance
    reason: str = "start"
    running: tuple[Rollout, ...] = ()
    waiting: tuple[tuple[Guidance, ...], ...] = ()
    plans: tuple[Plan, ...] = ()
    failures: int = 0
    unreachable: str = ""
    lack: str = ""
    effort: SearchEffort = NO_EFFORT
    found: tuple[np.ndarray, ...] = ()
    roadmap: Roadmap = NO_ROADMAP
    around: Movers = NOTHING
    finished: tuple[Rollout, ...] = ()
    latest: tuple[Rollout, ...] = ()
    idle_until: float = -np.inf
    hopeless_at: np.ndarray | None = None
    revision: str = ""
    aim: Aim | None = None
    missing: str = ""
    seconds: float = 0.0

    def __deepcopy__(self, memo) -> "Selection":
        return self

    @property
    def is_hopeless(self) -> bool:
        """Whether no candidate arrived in the latest round."""
        return self.hopeless_at is not None

    def has_given_up(self, attempts: int) -> bool:
        """Returns whether no further attempts are made to reach the target.

        If an obstacle may still move away, attempts continue.

        Args:
            attempts: Number of rounds with searches after which to give up.
        """
        return self.failures >= attempts and not len(self.around)


def start_selection(rule: SelectionRule) -> Selection:
    """Makes the initial selection.

    Args:
        rule: The rule, which contains the initial guidance.
    """
    return Selection(rule.start)


def on_the_same_world(
    rule: SelectionRule, selection: Selection, revision: str, aim: Aim
) -> Selection:
    """Returns the selection, or an initial one for a new target or map.

    Args:
        rule: The rule, which contains the initial guidance.
        selection: The selection so far.
        revision: Revision of the present map.
        aim: The present aim.
    """
    known = selection.aim
    if known is None or not known.equals(aim):
        guidance, reason = rule.first(aim), "new target"
    elif selection.revision != revision:
        guidance, reason = selection.guidance, "new map"
    else:
        return selection
    roadmap = selection.roadmap
    for corners in selection.found:
        roadmap = roadmap.with_path(corners)
    return Selection(
        guidance,
        reason,
        effort=selection.effort,
        roadmap=roadmap,
        around=NOTHING if reason == "new target" else selection.around,
        revision=revision,
        aim=aim,
    )
