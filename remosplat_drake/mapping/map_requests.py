"""`MapRequests`: what people have asked of the map."""

import dataclasses as dc


@dc.dataclass(frozen=True)
class MapRequests:
    """How often somebody has asked for what; copying returns the object.

    Counts lose no press between two looks, and need nobody to reset them.

    Attributes:
        frames: Frames to be taken.
        refines: Presses of the refine button.
        undos: Presses of the undo button.
        saves: Presses of the save button.
    """

    frames: int = 0
    refines: int = 0
    undos: int = 0
    saves: int = 0

    def __add__(self, other: "MapRequests") -> "MapRequests":
        """What two people have asked for together."""
        return MapRequests(
            self.frames + other.frames,
            self.refines + other.refines,
            self.undos + other.undos,
            self.saves + other.saves,
        )

    def __deepcopy__(self, memo) -> "MapRequests":
        return self
