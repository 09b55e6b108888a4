"""`MapStatus`: the version of the live map in use, and progress of the next."""

import dataclasses as dc

from remosplat_drake.signals.scene_map import SceneMap

MAKING = "making a map: "
"""Prefix of `MapStatus.text` while a map is being built."""


@dc.dataclass(frozen=True, eq=False)
class MapStatus:
    """The map in use, and progress of the next; a copy is the object itself.

    Attributes:
        scene_map: The map that the distance oracle uses.
        text: The result of the latest request, or the current activity, for
            operators.
        trouble: Description of the latest failure; empty after a request has
            succeeded.
        is_building: Whether requests are pending.
        frames: Number of camera frames of the next map.
        swaps: Number of times that the map in use was replaced.
    """

    scene_map: SceneMap
    text: str = ""
    trouble: str = ""
    is_building: bool = False
    frames: int = 0
    swaps: int = 0

    @property
    def news(self) -> str:
        """The message to print: a failure or success; empty during building."""
        if self.trouble:
            return self.trouble
        return "" if self.text.startswith(MAKING) else self.text

    def __deepcopy__(self, memo) -> "MapStatus":
        return self
