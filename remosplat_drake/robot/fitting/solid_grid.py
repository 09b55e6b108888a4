"""`SolidGrid`: a signed distance field of a solid body on a voxel grid."""

import dataclasses as dc

import numpy as np
import scipy

from remosplat_drake.robot.fitting.kernels.distance_transform import (
    squared_distances,
)

# Largest number of voxels around a link in which neighbours are examined.
_MAX_PAD = 24


@dc.dataclass(frozen=True, eq=False)
class SolidGrid:
    """Signed depth of a solid body on a voxel grid.

    Attributes:
        origin: Centre of the first voxel, shape (3,) [m].
        pitch: Edge length of a voxel [m]. The error of depths is about half of
            it.
        depth: Distance of each voxel to the surface, positive inside and
            negative outside, shape (nx, ny, nz) [m].
    """

    origin: np.ndarray
    pitch: float
    depth: np.ndarray

    def depth_at(self, p: np.ndarray) -> np.ndarray:
        """Interpolates the depth at points (..., 3), shape (...) [m]."""
        cell = (np.asarray(p) - self.origin) / self.pitch
        # Outside the grid, the distance to its border is subtracted.
        last = np.array(self.depth.shape) - 1
        inside = np.clip(cell, 0, last)
        beyond = self.pitch * np.linalg.norm(cell - inside, axis=-1)
        flat = inside.reshape(-1, 3).T
        value = scipy.ndimage.map_coordinates(self.depth, flat, order=1)
        return value.reshape(cell.shape[:-1]) - beyond

    def box(self, X_LN: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the corners of the grid's bounding box in another frame L.

        Args:
            X_LN: Pose of the body N in that frame L, shape (4, 4).

        Returns:
            Lower and upper corner, shape (3,) each [m].
        """
        half = 0.5 * self.pitch * np.array(self.depth.shape)
        center = self.origin + half - 0.5 * self.pitch
        p_L = X_LN[:3, :3] @ center + X_LN[:3, 3]
        reach = np.abs(X_LN[:3, :3]) @ half
        return p_L - reach, p_L + reach

    def contains(self, p: np.ndarray) -> np.ndarray:
        """Returns whether the voxels nearest to points (n, 3) are solid."""
        cell = np.rint((p - self.origin) / self.pitch).astype(int)
        on_grid = (cell >= 0) & (cell < self.depth.shape)
        result = np.asarray(on_grid.all(axis=1))
        result[result] = self.depth[tuple(cell[result].T)] >= 0
        return result


def make_solid_grid(
    surface: np.ndarray, pitch: float, floor: bool = False
) -> SolidGrid:
    """Computes the solid body that surface points enclose.

    Meshes of robots are rarely watertight: a link is open where the next link
    is attached. A voxel therefore counts as inside if rays from it meet the
    surface in at least four of the six axis directions. Points in a tube with
    open ends are inside; points in the hollow of an L or a U are not.

    Args:
        surface: Points denser than `pitch`, shape (n, 3) [m].
        pitch: Edge of a voxel [m].
        floor: Whether the body stands on the plane z = 0, so that spheres may
            protrude downwards. The body is then joined with its mirror image
            below the floor.
    """
    if floor:
        surface = np.vstack([surface, surface * [1, 1, -1]])
    # Two empty layers on each side leave room for negative depths.
    origin = surface.min(0) - 2 * pitch
    cell = np.round((surface - origin) / pitch).astype(int)
    occupied = np.zeros(cell.max(0) + 3, bool)
    occupied[tuple(cell.T)] = True
    seen = np.zeros(occupied.shape, np.int8)
    for axis in range(3):
        seen += np.logical_or.accumulate(occupied, axis)
        back = np.flip(occupied, axis)
        seen += np.flip(np.logical_or.accumulate(back, axis), axis)
    solid = scipy.ndimage.binary_closing(occupied | (seen >= 4))
    solid |= occupied
    # The surface runs through the middle of the occupied voxels.
    shell = occupied & scipy.ndimage.binary_dilation(~solid)
    return SolidGrid(origin, pitch, _depth(solid, solid & ~shell, pitch))


def join_solids(
    solid: SolidGrid, neighbours: list[tuple[SolidGrid, list[np.ndarray]]]
) -> SolidGrid:
    """Joins a link with the parts of its neighbours that never leave it.

    Typically, two links meet in a cylinder around their joint. The part of one
    link that extends into the other is hidden there at any joint angle.

    Args:
        solid: The link L.
        neighbours: For each neighbour N its solid and its poses X_LN, 4x4, at
            some joint positions; only points inside N at all of these poses are
            added.

    Returns:
        A grid that extends beyond the link by about its thickness.
    """
    thickness = int(np.ceil(solid.depth.max() / solid.pitch))
    pad = min(thickness, _MAX_PAD) + 2
    origin = solid.origin - pad * solid.pitch
    inside = np.pad(solid.depth >= 0, pad)
    for neighbour, poses in neighbours:
        # Neighbour N has no points outside its boxes.
        boxes = [neighbour.box(X_LN) for X_LN in poses]
        lower = np.max([box[0] for box in boxes], axis=0) - origin
        upper = np.min([box[1] for box in boxes], axis=0) - origin
        first = np.clip(np.floor(lower / solid.pitch), 0, None).astype(int)
        last = np.clip(np.ceil(upper / solid.pitch), -1, None).astype(int)
        block = tuple(map(slice, first, last + 1))
        hidden = first + np.argwhere(~inside[block])
        for X_LN in poses:
            p_L = origin + solid.pitch * hidden
            p_N = (p_L - X_LN[:3, 3]) @ X_LN[:3, :3]
            hidden = hidden[neighbour.contains(p_N)]
        inside[tuple(hidden.T)] = True
    # Closes gaps at joints, which are one or two millimetres wide.
    inside = scipy.ndimage.binary_closing(inside, iterations=2)
    core = scipy.ndimage.binary_erosion(inside)
    return SolidGrid(origin, solid.pitch, _depth(inside, core, solid.pitch))


def _depth(solid: np.ndarray, core: np.ndarray, pitch: float) -> np.ndarray:
    """Computes the depth [m], zero at the voxels of a solid around its core.

    A sheet that is thinner than three voxels has no core; its depth is zero.
    """
    inside = np.sqrt(squared_distances(~core))
    outside = np.sqrt(squared_distances(solid))
    return pitch * np.where(core, inside, -outside)
