"""`MapStatus`: the live map in use, and how the next one comes along."""

import dataclasses as dc

from remosplat_drake.signals.scene_map import SceneMap

MAKING = "making a map: "
"""What the text begins with while a map is being made."""


@dc.dataclass(frozen=True, eq=False)
class MapStatus:
    """The map in use and the progress of the next one; copying returns itself.

    Attributes:
        scene_map: The map that the distance oracle uses.
        text: The latest success, or what is being done, for operators.
        trouble: The latest failure; empty once something succeeded again.
        is_building: Whether requests are unanswered.
        frames: Number of camera frames that the next map is made from.
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
        """What is to be told once: the failure, or the text if no progress."""
        if self.trouble:
            return self.trouble
        return "" if self.text.startswith(MAKING) else self.text

    def __deepcopy__(self, memo) -> "MapStatus":
        return self
