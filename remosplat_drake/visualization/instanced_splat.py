"""`InstancedSplat`: glTF meshes of a splat, as instances of one small shape.

Each Gaussian is an instance of the shape (glTF's EXT_mesh_gpu_instancing) and
takes 26 bytes; a separate polygon would take 250 bytes. The material is unlit
(KHR_materials_unlit), since the colours of Gaussians already include light.
"""

import json

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh

from remosplat_drake.base.colors import linear_rgb
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization.gltf_buffer import (
    SIGNED,
    UNSIGNED,
    GltfBuffer,
)

_SIDES = 8
_RISE = 0.2
_INSTANCING = "EXT_mesh_gpu_instancing"
_UNLIT = "KHR_materials_unlit"
# In glTF, y is up, so Meshcat rotates glTF files about x.
_UPRIGHT = [-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]

Shape = tuple[np.ndarray, np.ndarray]
"""Type of a mesh: vertices, shape (n, 3), and faces as indices of vertices,
shape (m, 3). The faces' normals point outward by the right-hand rule."""


class InstancedSplat:
    """Makes meshes of one splat that share its data.

    Args:
        splat: The splat in its frame G; it has at least one Gaussian.
        n_sigma: Radius of the discs in standard deviations.
    """

    def __init__(self, splat: GaussianSplat, n_sigma: float):
        lower, upper = splat.p_GK.min(axis=0), splat.p_GK.max(axis=0)
        self._p_GC = (lower.astype(float) + upper) / 2
        R_GD, size = _discs(splat, n_sigma)
        # All lengths are stored as fractions of this length.
        self._unit = max(float((upper - lower).max()) / 2, float(size.max()))
        self._buffer = GltfBuffer()
        p_CK = (splat.p_GK - self._p_GC) / self._unit
        self._places = {
            "TRANSLATION": self._buffer.add_shares(p_CK, SIGNED),
            "_COLOR_0": self._buffer.add_shares(
                linear_rgb(splat.colors), UNSIGNED
            ),
        }
        self._poses = {
            "ROTATION": self._buffer.add_shares(quaternions(R_GD), SIGNED),
            "SCALE": self._buffer.add_shares(size / self._unit, UNSIGNED),
        }

    def surfels(self) -> Mesh:
        """Makes a mesh of discs that span the Gaussians' two largest axes.

        The discs are flat double cones. If two discs overlap, each one is
        visible on its side of the line between their centres, independent of
        the order of drawing.
        """
        return self._mesh(double_cone(_SIDES), self._places | self._poses)

    def points(self, radius: float) -> Mesh:
        """Makes a mesh of octahedra at the Gaussians' centres.

        Args:
            radius: Distance from a centre to a corner [m].
        """
        vertices, faces = double_cone(4)
        return self._mesh((vertices * radius / self._unit, faces), self._places)

    def _mesh(self, shape: Shape, attributes: dict[str, int]) -> Mesh:
        own = GltfBuffer(number=1, first=len(self._buffer.views))
        primitive = {
            "attributes": {"POSITION": own.add_floats(shape[0])},
            "indices": own.add_indices(shape[1].ravel()),
            "material": 0,
        }
        instances = {
            "translation": self._p_GC.tolist(),
            "scale": 3 * [self._unit],
            "mesh": 0,
            "extensions": {_INSTANCING: {"attributes": attributes}},
        }
        document = {
            "asset": {"version": "2.0"},
            "extensionsUsed": [_INSTANCING, _UNLIT],
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"rotation": _UPRIGHT, "children": [1]}, instances],
            "meshes": [{"primitives": [primitive]}],
            "materials": [{"extensions": {_UNLIT: {}}}],
            "buffers": [self._buffer.uri(), own.uri()],
            "bufferViews": self._buffer.views + own.views,
            "accessors": self._buffer.accessors + own.accessors,
        }
        file = MemoryFile(json.dumps(document), ".gltf", "splat")
        return Mesh(InMemoryMesh(mesh_file=file))


def _discs(
    splat: GaussianSplat, n_sigma: float
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the discs' frames D, with the thin axis last, and semi-axes."""
    rows = np.arange(len(splat))
    k0, k1 = np.argsort(-splat.scales, axis=1, kind="stable")[:, :2].T
    x, y = splat.R_GK[rows, :, k0], splat.R_GK[rows, :, k1]
    R_GD = np.stack([x, y, np.cross(x, y)], axis=2)
    a, b = n_sigma * splat.scales[rows, k0], n_sigma * splat.scales[rows, k1]
    return R_GD, np.stack([a, b, _RISE * b], axis=1)


def double_cone(sides: int) -> Shape:
    """Makes a mesh of two cones of radius 1 and height 1 with a common base.

    Args:
        sides: Number of corners of the base.
    """
    angle = 2 * np.pi * np.arange(sides) / sides
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    tips = np.array([[0, 0, 1.0], [0, 0, -1.0]])
    k = np.arange(sides)
    turn = (k + 1) % sides
    upper = np.stack([k, turn, 0 * k + sides], axis=1)
    lower = np.stack([turn, k, 0 * k + sides + 1], axis=1)
    return np.concatenate([rim, tips]), np.concatenate([upper, lower])


def quaternions(R: np.ndarray) -> np.ndarray:
    """Converts rotation matrices to quaternions.

    Args:
        R: Rotation matrices, shape (n, 3, 3).

    Returns:
        Unit quaternions x, y, z, w, shape (n, 4).
    """
    # These are the rows of 4 q q^T, each of which is a multiple of q. The row
    # with the largest diagonal entry is normalised, since it is far from zero.
    Q = np.empty((len(R), 4, 4))
    trace = np.trace(R, axis1=1, axis2=2)
    Q[:, 3, 3] = 1 + trace
    for i in range(3):
        Q[:, i, i] = 1 + 2 * R[:, i, i] - trace
    for i, j in ((0, 1), (0, 2), (1, 2)):
        Q[:, i, j] = Q[:, j, i] = R[:, i, j] + R[:, j, i]
    for i, (j, k) in enumerate(((2, 1), (0, 2), (1, 0))):
        Q[:, i, 3] = Q[:, 3, i] = R[:, j, k] - R[:, k, j]
    best = np.einsum("nii->ni", Q).argmax(axis=1)
    row = Q[np.arange(len(R)), best]
    return row / np.linalg.norm(row, axis=1, keepdims=True)
