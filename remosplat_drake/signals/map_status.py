"""`MapStatus`: what people are told about the live map."""

import dataclasses as dc

from remosplat_drake.signals.scene_map import SceneMap


@dc.dataclass(frozen=True, eq=False)
class MapStatus:
    """The map that counts now, and how the next one comes along.

    Copying returns the object itself.

    Attributes:
        scene_map: What the oracle asks.
        text: The latest good news, or what is being done.
        trouble: The latest bad news; empty once something went well again.
        is_building: Whether requests are unanswered.
        frames: Of which the next map is made.
        swaps: How often the map has changed.
    """

    scene_map: SceneMap
    text: str = ""
    trouble: str = ""
    is_building: bool = False
    frames: int = 0
    swaps: int = 0

    def __deepcopy__(self, memo) -> "MapStatus":
        return self
