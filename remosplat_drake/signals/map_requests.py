"""`MapRequests`: what operators have asked of the live map so far."""

import dataclasses as dc
from collections.abc import Sequence

from remosplat_drake.scene.primitive_scene import PrimitiveScene


@dc.dataclass(frozen=True)
class MapRequests:
    """How often each change of the map was asked for; copying returns itself.

    Counts lose no press between two looks, and need nobody to reset them. Only
    `unfinished` may fall: it does when a scan is broken off, since the frame
    before then was its last one.

    Attributes:
        frames: Number of camera frames asked for.
        refines: Number of presses of the refine button.
        undos: Number of presses of the undo button.
        saves: Number of presses of the save button.
        unfinished: Number of frames that more frames of the same scan follow;
            the map is rebuilt only after the last one.
        scene: Scene that a simulated camera sees from now on; None for no
            change.
    """

    frames: int = 0
    refines: int = 0
    undos: int = 0
    saves: int = 0
    unfinished: int = 0
    scene: PrimitiveScene | None = None

    def __add__(self, other: "MapRequests") -> "MapRequests":
        """Adds up the requests of two operators."""
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


def scene_in_turn(
    scenes: Sequence[PrimitiveScene], changes: int
) -> PrimitiveScene | None:
    """Returns the scene that a simulated camera sees after some changes.

    Args:
        scenes: The scene at the start, and those that take turns with it.
        changes: Number of changes that were asked for.

    Returns:
        The scene; None if there was no change, or there are no scenes.
    """
    return scenes[changes % len(scenes)] if scenes and changes else None
