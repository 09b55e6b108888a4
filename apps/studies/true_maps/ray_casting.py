"""Images of meshes by casting rays, and true distances, with Open3D."""

import dataclasses as dc

import numpy as np

from apps.studies.true_maps.scene import COLORS, MeshScene
from remosplat_drake.base.system_libraries import import_optional

_LIGHT_W = np.array([0.36, 0.48, 0.8])


@dc.dataclass(frozen=True, eq=False)
class Hits:
    """The first surfaces on rays; all arrays have the rays' shape (...).

    Attributes:
        z: Parameter t of the hit at start + t direction; inf without a hit.
        part: Index of the part that is hit; -1 for none.
        normal_W: Unit normal of the triangle, either way, shape (..., 3).
    """

    z: np.ndarray
    part: np.ndarray
    normal_W: np.ndarray


@dc.dataclass(frozen=True, eq=False)
class Nearest:
    """The surface points that are nearest to n points.

    Attributes:
        distance: Distances, shape (n,) [m].
        p_W: The surface points, shape (n, 3) [m].
        part: Index of the part that each is on, shape (n,).
        normal_W: Unit normal of the triangle, either way, shape (n, 3).
    """

    distance: np.ndarray
    p_W: np.ndarray
    part: np.ndarray
    normal_W: np.ndarray

    def selected(self, keep: np.ndarray) -> "Nearest":
        """Returns the points that a mask (n,) selects."""
        return Nearest(
            *(getattr(self, field.name)[keep] for field in dc.fields(self))
        )


class RayCaster:
    """Casts rays into a scene and measures distances to it.

    Args:
        scene: The scene.

    Raises:
        MissingExtraError: Open3D is not installed.
    """

    def __init__(self, scene: MeshScene):
        o3d = import_optional("open3d", "casting rays", "reconstruction")
        self._tensor = o3d.core.Tensor
        self._scene = o3d.t.geometry.RaycastingScene()
        self._none = self._scene.INVALID_ID
        for part in scene.parts:
            self._scene.add_triangles(
                self._tensor(part.mesh.p_WV.astype(np.float32)),
                self._tensor(part.mesh.triangles.astype(np.uint32)),
            )
        self._colors = np.array([COLORS[part.label] for part in scene.parts])

    def cast(self, p_W: np.ndarray, ray_W: np.ndarray) -> Hits:
        """Casts rays.

        Args:
            p_W: Starts of the rays, of a shape that broadcasts with theirs [m].
            ray_W: Their directions, shape (..., 3); of any length.
        """
        rays = np.concatenate([np.broadcast_to(p_W, ray_W.shape), ray_W], -1)
        hits = self._scene.cast_rays(self._tensor(rays.astype(np.float32)))
        part = hits["geometry_ids"].numpy().astype(np.int64)
        return Hits(
            hits["t_hit"].numpy(),
            np.where(part == self._none, -1, part),
            hits["primitive_normals"].numpy(),
        )

    def nearest(self, p_W: np.ndarray) -> Nearest:
        """Finds the surface points that are nearest to points (n, 3) [m]."""
        found = self._scene.compute_closest_points(
            self._tensor(p_W.astype(np.float32))
        )
        q_W = found["points"].numpy().astype(float)
        return Nearest(
            np.linalg.norm(p_W - q_W, axis=1),
            q_W,
            found["geometry_ids"].numpy().astype(np.int64),
            found["primitive_normals"].numpy().astype(float),
        )

    def colors(self, hits: Hits, p_W: np.ndarray) -> np.ndarray:
        """Returns colours at hits, shape (..., 3), uint8; black without a hit.

        Args:
            hits: The hits of the rays.
            p_W: Positions of the hits, shape (..., 3) [m].
        """
        light = 0.55 + 0.45 * np.abs(hits.normal_W @ _LIGHT_W)
        grain = np.sin(p_W @ _GRAIN_W).mean(axis=-1)
        shade = (light * (0.9 + 0.25 * grain))[..., None]
        color = np.clip(shade * self._colors[hits.part], 0, 255)
        return np.where(hits.part[..., None] < 0, 0, color).astype(np.uint8)


_GRAIN_W = np.array([[60.0, 13, -31, 7], [-22, 71, 17, 11], [19, -29, 53, -13]])
"""Wave vectors of a texture that distinguishes surfaces [rad/m]."""
