"""`SettledThings`: the objects at rest, which a map should contain."""

import dataclasses as dc
from collections.abc import Callable, Mapping
from itertools import groupby

import numpy as np

from remosplat_drake.detection.unseen_space import UNSEEN
from remosplat_drake.scene.mover import Mover, Movers

_STILL = 0.1
"""An object is at rest while the least and greatest coordinates of its boxes
change by at most this distance [m]. It is not zero, since boxes around the
visible part vary from image to image.
"""

_AGAIN = 10.0
"""A frame is requested again after this time if the map does not contain the
object yet [s].
"""


@dc.dataclass(frozen=True, eq=False)
class _Thing:
    """An object: outline, start of rest, time of the frame's request."""

    outline: np.ndarray
    since: float
    has_settled: bool = False
    asked: float = -np.inf


@dc.dataclass(frozen=True, eq=False)
class SettledThings:
    """Objects that were seen, and the number of requested frames.

    It is immutable; copying returns the object itself.

    Attributes:
        things: The objects, keyed by their names.
        asked: Number of requested frames so far.
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
        """Updates the objects with the present movers.

        A frame is requested for a settled object as soon as the map's camera
        can see it. It is requested again after ten seconds if the object is
        still among the movers.

        Args:
            movers: The movers; movers from a source other than cameras never
                settle.
            time: The present time [s].
            in_view: Function that returns whether the map's camera can see a
                point in W, shape (3,) [m].
            settle: Time after which an object at rest has settled [s].
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
        """Returns the movers that had not settled at the last update.

        Args:
            movers: The movers. Movers from a source other than cameras never
                settle; `UNSEEN` ones are omitted.
        """
        stays = {name for name, t in self.things.items() if t.has_settled}
        stays.add(UNSEEN)
        passing = [m for m in movers if _thing_of(m) not in stays]
        return dc.replace(movers, movers=passing)


def _thing_of(mover: Mover) -> str:
    """Returns the object of a mover: "seen 3" for "seen 3.1"."""
    return mover.name.partition(".")[0]


def _outline(parts: list[Mover]) -> np.ndarray:
    """Returns least and greatest coordinates of an object, (2, 3) [m]."""
    middle = np.array([part.X_WM.translation() for part in parts])
    size = [
        np.abs(part.X_WM.rotation().matrix()) @ part.half_extents + part.radius
        for part in parts
    ]
    return np.stack([(middle - size).min(axis=0), (middle + size).max(axis=0)])
