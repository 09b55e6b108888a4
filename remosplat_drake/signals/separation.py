"""`Separation`: the distance to a mover and the required distance."""

import dataclasses as dc


@dc.dataclass(frozen=True)
class Separation:
    """The pair of a link and a mover with the least margin.

    Attributes:
        link: Name of the link.
        mover: Name of the mover.
        distance: Distance of their surfaces [m].
        needed: The protective separation distance S_p between them [m].
    """

    link: str
    mover: str
    distance: float
    needed: float

    @property
    def margin(self) -> float:
        """The distance minus S_p [m]."""
        return self.distance - self.needed
