"""`Selection`: the selected guidance, and the state of its selection."""

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
from remosplat_drake.signals.distance_field import DistanceField


@dc.dataclass(frozen=True, eq=False)
class Selection:
    """The selector's state and decision; copying returns the object itself.

    Attributes:
        guidance: The selected guidance, which the controller follows now.
        reason: Reason why this guidance was selected, for display.
        running: The present group of rollouts, which began from the same state,
            including those that have ended; empty between rounds.
        waiting: Candidates of the present round that have not been simulated
            yet, as a tuple for each tier (stopping distance).
        plans: Results of the searches for paths in the present round, one for
            each stopping distance that was tried.
        failures: Number of consecutive rounds with a search in which no
            candidate reached the target.
        unreachable: Reason why no path to the target was found, for display;
            empty if a path was found, or if no path was searched.
        lack: `Plan.lack` of the search that found no path; empty if
            `unreachable` is empty.
        effort: Effort of all searches since the start of the run.
        found: Corners of the paths that were found to the present target in the
            present map.
        roadmap: Corners of the paths that were found earlier.
        around: Standing movers that were obstacles in the latest search for a
            path.
        finished: Rollouts of the earlier groups of the present round. The first
            is that of the guidance that was selected before the round.
        latest: Rollouts of the latest complete round.
        idle_until: Time before which no rollouts are computed [s]; see also
            `hopeless_at`.
        hopeless_at: Configuration in which the latest round ended without an
            arrival, shape (n_q,); None otherwise. When the robot has moved away
            from this configuration, the next round starts even before
            `idle_until`.
        arriving_at: Configuration in which the latest round ended with an
            arrival, shape (n_q,); None otherwise.
        refuted: Number of times that a rollout arrived although the robot,
            which followed the same guidance, stood still.
        revision: Revision of the map that the present round uses.
        aim: The aim of the present round.
        tier: Index of the largest stopping distance that is used. Larger ones
            are not used, because the robot was too near to obstacles when it
            received the target or the map.
        missing: Reason why no rollouts are simulated although they should be,
            for display; empty if rollouts are simulated.
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
    arriving_at: np.ndarray | None = None
    refuted: int = 0
    revision: str = ""
    aim: Aim | None = None
    tier: int = 0
    missing: str = ""
    seconds: float = 0.0

    def __deepcopy__(self, memo) -> "Selection":
        return self

    @property
    def is_hopeless(self) -> bool:
        """Whether no candidate reached the target in the latest round."""
        return self.hopeless_at is not None

    def has_given_up(self, attempts: int) -> bool:
        """Returns whether the selector has given up reaching the target.

        The selector does not give up while an obstacle may still move away.

        Args:
            attempts: Number of rounds with a search after which the selector
                gives up.
        """
        return self.failures >= attempts and not len(self.around)


def start_selection(rule: SelectionRule) -> Selection:
    """Makes the initial `Selection`.

    Args:
        rule: The selector's settings.
    """
    return Selection(rule.start)


def on_the_same_world(
    rule: SelectionRule,
    selection: Selection,
    q: np.ndarray,
    field: DistanceField,
    aim: Aim,
) -> Selection:
    """Returns the given selection, or an initial one for a new target or map.

    Args:
        rule: The selector's settings.
        selection: The selection so far.
        q: Measured configuration, shape (n_q,) [rad, m].
        field: The present map.
        aim: The present aim.
    """
    known, revision = selection.aim, field.revision
    is_new = known is None or not known.equals(aim)
    if not is_new and selection.revision == revision:
        return selection
    tier = rule.kept_tier(q, field)
    if is_new:
        guidance, reason = rule.from_tier(tier).first(aim), "new target"
    else:
        guidance, reason = selection.guidance, "new map"
    roadmap = selection.roadmap
    for corners in selection.found:
        roadmap = roadmap.with_path(corners)
    return Selection(
        guidance,
        reason,
        effort=selection.effort,
        roadmap=roadmap,
        around=NOTHING if is_new else selection.around,
        revision=revision,
        aim=aim,
        tier=tier,
    )
