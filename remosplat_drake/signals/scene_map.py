"""`SceneMap`: one version of what is known of the scene."""

import dataclasses as dc

from remosplat_drake.signals.coverage import Coverage
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_tiles import SurfelTile


@dc.dataclass(frozen=True, eq=False)
class SceneMap:
    """One version of the map, which never changes.

    It crosses Drake's ports, so copying returns the object itself.

    Attributes:
        version: Counts up; 0 is what the scenario began with.
        parent: The version that this one was made after; None for the first.
        frames: Names of the camera frames that are in it.
        time: When the newest of them was taken, by the diagram's clock [s];
            -inf without frames.
        field: What the distance oracle asks.
        splat_W: The surfaces; None where there is no splat.
        coverage: Which part of space was seen; None where nobody looked.
        tiles: The splat, ready to be drawn.
        quality: One line about it for people.
    """

    version: int
    parent: int | None
    frames: tuple[str, ...]
    time: float
    field: DistanceField
    splat_W: GaussianSplat | None = None
    coverage: Coverage | None = None
    tiles: tuple[SurfelTile, ...] = ()
    quality: str = ""

    def __deepcopy__(self, memo) -> "SceneMap":
        return self
