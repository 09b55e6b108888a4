"""`SettledThings`: what stays where it is, so that a map should show it."""

import dataclasses as dc
from collections.abc import Callable, Mapping
from itertools import groupby

import numpy as np

from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.sight.unseen_space import UNSEEN

_STILL = 0.1
"""A thing stays put as long as its middle, and how far it reaches, change by no
more than that: boxes around what is seen of it are not the same each time [m].
"""

_AGAIN = 10.0
"""Time after which a map is asked once more, where it still does not show it
[s]."""


@dc.dataclass(frozen=True, eq=False)
class _Thing:
    """A thing, where it is, since when, and when a map was asked for it."""

    outline: np.ndarray
    since: float
    has_settled: bool = False
    asked: float = -np.inf


@dc.dataclass(frozen=True, eq=False)
class SettledThings:
    """Things that were seen, and how often a map was asked to show one.

    A value; copying returns the object itself.

    Attributes:
        things: The things, by their names.
        asked: Number of times that a map was asked so far.
    """

    things: Mapping[str, _Thing] = dc.field(default_factory=dict)
    asked: int = 0

    def __deepcopy__(self, memo) -> "SettledThings":
        return self

    def after(
        self,
        movers: Movers,
        time: float,
        in_view: Callable[[np.ndarray], bool],
        settle: float,
    ) -> "SettledThings":
        """Looks at what moves once more.

        A map is asked for what has settled as soon as the map's own camera can
        see it, and once more after ten seconds if it is among movers still.

        Args:
            movers: What cameras tell; movers that are known otherwise, and
                everywhere, are no map's business.
            time: The present time [s].
            in_view: Says whether the map's camera can see a point in W, shape
                (3,) [m].
            settle: Time after which what stays put has settled [s].
        """
        if not movers.cameras:
            return self
        things: dict[str, _Thing] = {}
        asked = self.asked
        for name, parts in groupby(movers, key=_thing_of):
            if name == UNSEEN:
                continue
            outline = _outline(list(parts))
            thing = self.things.get(name)
            if thing is None or np.abs(outline - thing.outline).max() > _STILL:
                thing = _Thing(outline, time)
            if not thing.has_settled and time - thing.since >= settle:
                thing = dc.replace(thing, has_settled=True)
            is_due = thing.has_settled and time - thing.asked >= _AGAIN
            if is_due and in_view(thing.outline.mean(axis=0)):
                thing = dc.replace(thing, asked=time)
                asked += 1
            things[name] = thing
        return SettledThings(things, asked)

    def passing(self, movers: Movers) -> Movers:
        """Returns what had not settled at the last look.

        Args:
            movers: What moves. Nothing settles that is known otherwise than by
                cameras; and what nobody sees is nothing.
        """
        stays = {name for name, t in self.things.items() if t.has_settled}
        stays.add(UNSEEN)
        passing = [m for m in movers if _thing_of(m) not in stays]
        return dc.replace(movers, movers=passing)


def _thing_of(mover: Mover) -> str:
    """The thing that a mover is a part of: "seen 3" of "seen 3.1"."""
    return mover.name.partition(".")[0]


def _outline(parts: list[Mover]) -> np.ndarray:
    """Least and greatest coordinates of a thing's parts, shape (2, 3) [m]."""
    middle = np.array([part.X_WM.translation() for part in parts])
    size = [
        np.abs(part.X_WM.rotation().matrix()) @ part.half_extents + part.radius
        for part in parts
    ]
    return np.stack([(middle - size).min(axis=0), (middle + size).max(axis=0)])
