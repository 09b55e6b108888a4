"""`Thing`: kind and name of an object near a robot."""

import dataclasses as dc

MAP = "map"
"""Kind: the surface of a map, built from camera images."""
UNSEEN = "unseen"
"""Kind: space that no camera has seen."""
SOLID = "solid"
"""Kind: a solid of known geometry."""
FLOOR = "floor"
"""Kind: the floor."""

KINDS = (MAP, UNSEEN, SOLID, FLOOR)
"""All kinds of objects."""


@dc.dataclass(frozen=True)
class Thing:
    """An object or a surface of the scene, to be named in a sentence.

    Attributes:
        kind: One of `KINDS`.
        name: Name of the object in a sentence, with its article.
    """

    kind: str
    name: str


THE_MAP = Thing(MAP, "the map's surface")
UNSEEN_SPACE = Thing(UNSEEN, "unseen space")
THE_FLOOR = Thing(FLOOR, "the floor")
