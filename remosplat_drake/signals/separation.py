"""`Separation`: how near what moves is, beside how near it may be."""

import dataclasses as dc


@dc.dataclass(frozen=True)
class Separation:
    """The pair of a link and a mover that have the least to spare.

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
        """What the distance has above S_p [m]."""
        return self.distance - self.needed
