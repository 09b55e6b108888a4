"""`UnknownSpaceField`: distances to space that no camera has seen."""

import hashlib
from collections.abc import Mapping
from functools import cached_property

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.oracle.kernels.nearest_voxel import query
from remosplat_drake.oracle.sphere_queries import sphere_queries
from remosplat_drake.oracle.voxel_octree import (
    VoxelOctree,
    child_masks,
    level_table,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.compiled_map import Maps, together
from remosplat_drake.signals.coverage import UNSEEN, Coverage
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.thing import UNSEEN_SPACE, Thing


class UnknownSpaceField(DistanceField):
    """The exact signed distance to the unseen voxels of a grid, as one solid.

    Space outside the grid is unseen, too. If the centre of a sphere is in
    unseen space, its distance is negative, and its direction points away from
    the nearest seen voxel. For each sphere, voxels with centres below its
    `ignore_below` count as seen.

    The result is exact, and equals that of `unknown_space_reference`.

    Args:
        unseen: Whether each voxel is unseen, shape (nx, ny, nz), bool.
        lower: Lower corner of the grid in W, shape (3,) [m].
        voxel: Edge length of a voxel [m].
        prepared: The attribute `prepared` of an equal field, so that the octree
            is not computed again. Kernels do not check its indices.

    Raises:
        RemoSplatError: The grid is invalid, or none of its voxels has been
            seen.
    """

    def __init__(
        self,
        unseen: np.ndarray,
        lower: np.ndarray,
        voxel: float,
        *,
        prepared: Mapping[str, np.ndarray] | None = None,
    ):
        unseen = np.asarray(unseen, bool)
        lower = np.asarray(lower, float)
        if unseen.ndim != 3 or lower.shape != (3,) or not voxel > 0:
            raise RemoSplatError(
                f"not a grid of voxels: shape {unseen.shape}, {lower=}, "
                f"{voxel=}"
            )
        if unseen.all():
            raise RemoSplatError("no voxel of the grid has been seen")
        digest = hashlib.sha256(np.packbits(unseen).tobytes())
        digest.update(repr((unseen.shape, lower.tolist(), voxel)).encode())
        self.revision = f"unknown-space-{digest.hexdigest()[:16]}"
        grid = _prepare(unseen) if prepared is None else prepared
        for array in grid.values():
            # The conversion gives all arrays the same type, so that the kernel
            # is compiled only once.
            array.flags.writeable = False
        self._octree = VoxelOctree(
            grid["unseen"],
            grid["children"],
            level_table(grid["unseen"].shape),
            lower - voxel,
            float(voxel),
        )
        self._packed = Packed(self._octree)

    @property
    def unseen(self) -> np.ndarray:
        """Whether each voxel is unseen, shape (nx, ny, nz), bool."""
        return self._octree.unseen[1:-1, 1:-1, 1:-1]

    @property
    def prepared(self) -> dict[str, np.ndarray]:
        """Precomputed arrays for the argument `prepared` of an equal field."""
        return {
            "unseen": self._octree.unseen,
            "children": self._octree.children,
        }

    @property
    def compiled(self) -> Packed[VoxelOctree]:
        """The voxels and their octree; see `DistanceField.compiled`."""
        return self._packed

    @cached_property
    def compiled_rows(self) -> Packed[Maps]:
        """The voxels and their octree; see `DistanceField.compiled_rows`."""
        return together([self._packed])

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Measures the clearance of each sphere to unseen space.

        Args:
            spheres: The robot spheres, placed in W.
            max_distance: Rows at or beyond this distance are omitted [m].

        Raises:
            ValueError: A centre is not finite, or a radius or `ignore_below` is
                NaN.
        """
        asked = sphere_queries(spheres, max_distance)
        answer = np.empty((len(spheres), 8))
        query(self._packed, asked, answer)
        found = np.flatnonzero(answer[:, 0] > 0)
        answer = answer[found]
        return Clearances(
            sphere=found,
            distance=answer[:, 1] - spheres.radius[found],
            direction_W=answer[:, 5:8],
            p_WC=answer[:, 2:5],
            revision=self.revision,
        )

    @property
    def surfaces(self) -> None:
        """None: unseen space has no surface; see `DistanceField.surfaces`."""
        return None

    def thing_at(self, p_W: np.ndarray) -> Thing:
        """Returns "unseen space"; see `DistanceField.thing_at`."""
        return UNSEEN_SPACE


def unknown_space_field(
    coverage: Coverage, *, prepared: Mapping[str, np.ndarray] | None = None
) -> UnknownSpaceField:
    """Makes a distance field of unseen space.

    Args:
        coverage: The space that cameras have seen.
        prepared: The attribute `prepared` of an equal field; see
            `UnknownSpaceField`.

    Raises:
        RemoSplatError: No voxel has been seen.
    """
    unseen = coverage.state == UNSEEN
    return UnknownSpaceField(
        unseen, coverage.lower, coverage.voxel, prepared=prepared
    )


def _prepare(unseen: np.ndarray) -> dict[str, np.ndarray]:
    """Returns the arrays of a `VoxelOctree`."""
    padded = np.pad(unseen, 1, constant_values=True)
    return {"unseen": padded, "children": child_masks(padded)}
