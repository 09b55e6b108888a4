"""`MapRequests`: what people have asked of the map."""

import dataclasses as dc

from remosplat_drake.scene.primitive_scene import PrimitiveScene


@dc.dataclass(frozen=True)
class MapRequests:
    """How often somebody has asked for what; copying returns the object.

    Counts lose no press between two looks, and need nobody to reset them.
    The only one that may fall is `unfinished`: a scan that is broken off was
    finished by its last frame.

    Attributes:
        frames: Frames to be taken.
        refines: Presses of the refine button.
        undos: Presses of the undo button.
        saves: Presses of the save button.
        unfinished: Those of the frames that more of a scan follow: a map is
            made of them together with the last one.
        scene: What a simulated camera sees from now on; None: no change.
    """

    frames: int = 0
    refines: int = 0
    undos: int = 0
    saves: int = 0
    unfinished: int = 0
    scene: PrimitiveScene | None = None

    def __add__(self, other: "MapRequests") -> "MapRequests":
        """What two people have asked for together."""
        return MapRequests(
            self.frames + other.frames,
            self.refines + other.refines,
            self.undos + other.undos,
            self.saves + other.saves,
            self.unfinished + other.unfinished,
            self.scene if other.scene is None else other.scene,
        )

    def __deepcopy__(self, memo) -> "MapRequests":
        return self
