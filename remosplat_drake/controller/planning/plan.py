"""`Plan`: the result of a search for a path, and its cost."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.program.path import Path

UNREACHED = "unreached"
"""Value of `Plan.lack`: no configuration reaches the target, or none was
found."""
CRAMPED = "cramped"
"""Value of `Plan.lack`: in all configurations found that reach the target, the
robot is too near to the scene, to a mover or to itself."""
CUT_OFF = "cut off"
"""Value of `Plan.lack`: no path was found to the configurations that reach the
target."""


@dc.dataclass(frozen=True, eq=False)
class Plan:
    """The result of a search for a path.

    Attributes:
        path: The path; None if no path was found.
        reason: Reason why no path was found, for display; empty if a path was
            found.
        checks: Number of configurations and motions that were checked.
        goals: Number of goal configurations.
        seconds: Wall-clock time of the search [s].
        corners: Corners of the path before they were rounded off, shape (k,
            n_q) [rad, m]; None if no path was found.
        lack: Kind of the failure: UNREACHED, CRAMPED or CUT_OFF; empty if a
            path was found.
    """

    path: Path | None
    reason: str
    checks: int
    goals: int
    seconds: float = 0.0
    corners: np.ndarray | None = None
    lack: str = ""


@dc.dataclass(frozen=True)
class SearchEffort:
    """The effort of all searches for paths in a run.

    Attributes:
        searches: Number of searches.
        checks: Number of configurations and motions that the searches checked.
        seconds: Wall-clock time of all searches [s].
        first_path: Wall-clock time of all searches up to and including the one
            that found the first path [s]; None if no path was found.
        first_checks: Number of checks up to the first path.
    """

    searches: int = 0
    checks: int = 0
    seconds: float = 0.0
    first_path: float | None = None
    first_checks: int = 0

    def with_plan(self, plan: Plan) -> "SearchEffort":
        """Returns the effort including another search.

        Args:
            plan: The result of the search.
        """
        checks, seconds = self.checks + plan.checks, self.seconds + plan.seconds
        first = {}
        if self.first_path is None:
            first["first_checks"] = checks
            first["first_path"] = None if plan.path is None else seconds
        return dc.replace(
            self,
            searches=self.searches + 1,
            checks=checks,
            seconds=seconds,
            **first,
        )


NO_EFFORT = SearchEffort()
"""The effort before the first search."""
