"""`KnownScene`: a cached grid of distances to the map's surfaces."""

import numpy as np

from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.kernels.scan import FAR, STEP, UNASKED
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

NODE = 0.02
"""Distance between neighbouring nodes of the grid [m]."""

_PORTION = 2000
"""The distances of this many nodes are computed at a time."""

_SHOWN = 1500
"""At most this many surface points are used to check a camera's pose."""


class KnownScene:
    """A map's distances at the nodes of a grid, computed when first needed.

    A fixed camera sees the same points in every image, and a moving camera sees
    nearly the same points as in the previous image. So most queries are table
    lookups. Each node is computed once, since an object belongs to one version
    of the map.

    Args:
        field: The map, without unseen space; None for an empty map.
        config: Settings, with the box of the grid.
        surface_W: Points on the map's surfaces in W, shape (n, 3) [m], see
            `surface_points`. Without points, the cameras' poses are not
            checked.

    Attributes:
        revision: Identifier of the map's content.
        surface_W: A selection of the given points on surfaces.
        nodes: Distance at each node, see `kernels.scan`, uint8.
        lower: Position of the first node, shape (3,) [m].
    """

    def __init__(
        self,
        field: DistanceField | None,
        config: DetectionConfig,
        surface_W: np.ndarray | None = None,
    ):
        self._field = None if field is None else field.surfaces
        if self._field is not None and not self._field.is_lipschitz:
            # Depth views of a point take as long as hundreds of distances to
            # ellipsoids.
            self._field = self._field.for_planning
        self.revision = "" if field is None else field.revision
        self.lower = np.array(config.lower, float)
        size = np.subtract(config.upper, config.lower)
        shape = np.ceil(size / NODE).astype(int) + 1
        empty = UNASKED if self._field is not None else FAR
        self.nodes = np.full(shape, empty, np.uint8)
        points = np.zeros((0, 3)) if surface_W is None else surface_W
        every = max(1, len(points) // _SHOWN)
        self.surface_W = np.ascontiguousarray(points[::every], float)

    def __deepcopy__(self, memo) -> "KnownScene":
        return self

    def distances(self, p_W: np.ndarray) -> np.ndarray:
        """Returns the map's distances at the nodes nearest to points, (n,) [m].

        For points outside the box, the result is the largest distance that a
        node can store.

        Args:
            p_W: Points in W, shape (n, 3) [m].
        """
        place = np.rint((p_W - self.lower) / NODE).astype(int)
        inside = ((place >= 0) & (place < self.nodes.shape)).all(axis=1)
        index = tuple(place[inside].T)
        flat = np.asarray(np.ravel_multi_index(index, self.nodes.shape))
        kept = self.nodes.reshape(-1)
        unasked = np.unique(flat[kept[flat] == UNASKED])
        if len(unasked):
            self.ask(unasked)
        found = np.full(len(p_W), FAR * STEP)
        found[inside] = STEP * kept[flat]
        return found

    def ask(self, asked: np.ndarray) -> None:
        """Computes and stores the distances of nodes.

        Args:
            asked: Flat indices of the nodes, shape (n,).
        """
        places = np.stack(np.unravel_index(asked, self.nodes.shape), axis=1)
        p_W = self.lower + NODE * places
        distance = self._distances(p_W)
        steps = np.clip(np.rint(distance / STEP), 0, FAR)
        self.nodes.reshape(-1)[asked] = steps.astype(np.uint8)

    def prepare_as(self, other: "KnownScene") -> None:
        """Computes all nodes that were computed for another map.

        The nodes are computed in small portions, so that other threads can run
        in between.

        Args:
            other: A map with the same grid.
        """
        asked = np.flatnonzero(other.nodes.reshape(-1) != UNASKED)
        mine = asked[self.nodes.reshape(-1)[asked] == UNASKED]
        for first in range(0, len(mine), _PORTION):
            self.ask(mine[first : first + _PORTION])

    def _distances(self, p_W: np.ndarray) -> np.ndarray:
        assert self._field is not None
        limit = FAR * STEP
        found = self._field.clearances(Spheres.at(p_W), limit)
        return np.minimum(found.per_sphere(len(p_W)), limit)


def surface_points(
    splat_W: GaussianSplat | None, truth: PrimitiveScene | None
) -> np.ndarray:
    """Returns points on the surfaces of a map in W, shape (n, 3) [m].

    Args:
        splat_W: The splat, in W; None if there is none.
        truth: Solids, whose faces are sampled; None if there are none.
    """
    points = [np.zeros((0, 3))]
    if splat_W is not None:
        opaque = splat_W.opacities > 0.5
        points.append(splat_W.p_GK[opaque].astype(float))
    if truth is not None:
        points.extend(_faces(truth))
    return np.concatenate(points)


def _faces(scene: PrimitiveScene) -> list[np.ndarray]:
    """Returns points that are evenly distributed over each solid's faces."""
    rng = np.random.default_rng(0)
    found = []
    for solid in scene.primitives:
        direction = rng.standard_normal((200, 3))
        if isinstance(solid, Box):
            size = np.abs(direction / solid.half_extents).max(axis=1)
            p_P = direction / size[:, None]
        else:
            around = np.hypot(direction[:, 0], direction[:, 1])
            size = np.maximum(
                around / solid.radius,
                np.abs(direction[:, 2]) / solid.half_height,
            )
            p_P = direction / size[:, None]
        X_WP = solid.X_WP.GetAsMatrix4()
        found.append(p_P @ X_WP[:3, :3].T + X_WP[:3, 3])
    return found
