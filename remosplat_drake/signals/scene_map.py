"""`SceneMap`: one version of the map of the scene."""

import dataclasses as dc

from remosplat_drake.signals.coverage import Coverage
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_tiles import SurfelTile


@dc.dataclass(frozen=True, eq=False)
class SceneMap:
    """One immutable version of the map; copying returns the object itself.

    A live map has many versions, each made from an earlier one.

    Attributes:
        version: Number of the version, counting up; 0 is the scenario's own
            map.
        parent: Number of the version that this one was made from; None for the
            first.
        frames: Names of the camera frames that the map was made from.
        time: Time at which the newest of these frames was taken, by the
            diagram's clock [s]; -inf without frames.
        field: Distance field of the map, which the distance oracle evaluates.
        splat_W: The map's Gaussian splat in W; None if it is made of known
            solids.
        coverage: The part of the workspace that the cameras saw; None if
            unknown.
        tiles: The splat as triangle meshes for Meshcat.
        quality: The reliability of the map in one line, for operators.
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

    @property
    def is_blank(self) -> bool:
        """Whether the map is empty, as before the first scan."""
        return self.splat_W is None or not len(self.splat_W)

    def __deepcopy__(self, memo) -> "SceneMap":
        return self
