"""`MapStatus`: the live map in use, and progress of the next one."""

import dataclasses as dc

from remosplat_drake.signals.scene_map import SceneMap

MAKING = "making a map: "
"""Prefix of the text while a map is being built."""


@dc.dataclass(frozen=True, eq=False)
class MapStatus:
    """The map in use, and progress of the next; copies are the object itself.

    Attributes:
        scene_map: The map that the distance oracle uses.
        text: The latest success or the current activity, for operators.
        trouble: The latest failure; empty after the next success.
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
        """A message to print once: the latest failure or else success."""
        if self.trouble:
            return self.trouble
        return "" if self.text.startswith(MAKING) else self.text

    def __deepcopy__(self, memo) -> "MapStatus":
        return self
