"""`Selection`: the state of the choice between guidances."""

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
        reason: Why it is followed, for people.
        running: The rollouts in progress, which began together, and those of
            them that have ended already; empty between rounds.
        waiting: Candidates of the present round still to be tried, a tuple for
            each tier.
        plans: Results of the searches of the present round, one for each
            stopping distance that was tried.
        failures: Number of rounds in a row with searches in which nothing
            arrives.
        unreachable: Why no path leads to the target as far as is known, for
            people; empty if one does or none was searched.
        effort: Effort of all searches since the start of the run.
        found: Corners of the paths that were found to the present target on
            the present map.
        roadmap: Corners of those that were found before.
        around: Standing movers that were obstacles when a path was searched.
        finished: Rollouts of the present round before those, the first of them
            with the guidance that is followed.
        latest: Rollouts of the latest complete round.
        idle_until: Time before which nothing is computed [s], but see
            `hopeless_at`.
        hopeless_at: Configuration at which the latest round has ended without
            an arrival, shape (n_q,), else None; once the robot has moved on
            from it, the next round starts before `idle_until`.
        revision: Revision of the map that the round looks at.
        aim: The aim of the round.
        missing: Why nothing is simulated although it should be, for people;
            empty if it is.
        seconds: Wall-clock time of the latest update [s].
    """

    guidance: Guidance
    reason: str = "start"
    running: tuple[Rollout, ...] = ()
    waiting: tuple[tuple[Guidance, ...], ...] = ()
    plans: tuple[Plan, ...] = ()
    failures: int = 0
    unreachable: str = ""
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
        """Whether nothing arrived in the latest round."""
        return self.hopeless_at is not None

    def has_given_up(self, attempts: int) -> bool:
        """Returns whether a target that nothing leads to is not tried for more.

        Obstacles that may leave are waited for.

        Args:
            attempts: Number of rounds with searches that are made.
        """
        return self.failures >= attempts and not len(self.around)


def start_selection(rule: SelectionRule) -> Selection:
    """Makes the selection before anything is known.

    Args:
        rule: The rule, which names the guidance to start with.
    """
    return Selection(rule.start)


def on_the_same_world(
    rule: SelectionRule, selection: Selection, revision: str, aim: Aim
) -> Selection:
    """Returns the selection, or a fresh one for a new target or a new map.

    Args:
        rule: The rule, which names the guidance to start with.
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
