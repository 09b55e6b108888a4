"""`Separation`: the present and the required distance from a mover."""

import dataclasses as dc


@dc.dataclass(frozen=True)
class Separation:
    """The link and the mover with the least margin, and their distance.

    Attributes:
        link: Name of the link.
        mover: Name of the mover.
        distance: Distance between the surfaces of link and mover [m].
        needed: The protective separation distance S_p of link and mover [m].
    """

    link: str
    mover: str
    distance: float
    needed: float

    @property
    def margin(self) -> float:
        """The distance minus S_p; no other pair has a smaller margin [m]."""
        return self.distance - self.needed
