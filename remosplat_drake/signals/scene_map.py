"""`SceneMap`: one version of the map of the scene."""

import dataclasses as dc

from remosplat_drake.signals.coverage import Coverage
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_tiles import SurfelTile


@dc.dataclass(frozen=True, eq=False)
class SceneMap:
    """One immutable version of the map; copying returns the object itself.

    A live map has many versions. Each is made from an earlier version.

    Attributes:
        version: Number of the version, which increases; 0 is the map of the
            scenario.
        parent: Number of the version from which this version was made; None for
            the first version.
        frames: Names of the camera frames from which the map was made.
        time: Time at which the newest of these frames was taken, by the
            diagram's clock [s]; -inf if there are no frames.
        field: Distance field of the map, which the distance oracle evaluates.
        splat_W: The map's Gaussian splat in W; None if the map consists of
            known solids.
        coverage: The part of the workspace that cameras have seen; None if it
            is unknown.
        tiles: The splat as triangle meshes for Meshcat.
        quality: Statement about the reliability of the map in one line, for
            operators.
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
