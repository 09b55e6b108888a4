"""`MapRequests`: counts of operators' requests to the live map."""

import dataclasses as dc
from collections.abc import Sequence

from remosplat_drake.scene.primitive_scene import PrimitiveScene


@dc.dataclass(frozen=True)
class MapRequests:
    """Counts of requests to the map; copying returns the object itself.

    An increased count is a request. So no request is lost between two reads,
    and no flag must be reset. Only `unfinished` may decrease: if a scan is
    aborted, its latest frame becomes its last one.

    Attributes:
        frames: Number of requested camera frames.
        refines: Number of presses of the refine button.
        undos: Number of presses of the undo button.
        saves: Number of presses of the save button.
        unfinished: Number of requested frames that are followed by more frames
            of the same scan. The map is rebuilt only after the last frame of a
            scan.
        scene: Scene that a simulated camera shows from now on; None if it does
            not change.
    """

    frames: int = 0
    refines: int = 0
    undos: int = 0
    saves: int = 0
    unfinished: int = 0
    scene: PrimitiveScene | None = None

    def __add__(self, other: "MapRequests") -> "MapRequests":
        """Returns the sum of the requests of two operators."""
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
    """Returns the scene that a simulated camera shows after n changes.

    Args:
        scenes: The scenes, which the camera shows in turn. The first one is the
            scene at the start.
        changes: Number n of requested changes.

    Returns:
        The scene; None if there was no change, or there are no scenes.
    """
    return scenes[changes % len(scenes)] if scenes and changes else None
