"""`KnownScene`: how far from all that the map knows a place is, at a glance."""

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.sight.kernels.scan import FAR, STEP, UNASKED
from remosplat_drake.sight.sight_config import SightConfig
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

NODE = 0.02
"""Distance between neighbouring nodes of the grid [m]."""

_PORTION = 2000
"""Nodes that are measured at once while others wait."""

_SHOWN = 1500
"""Most points of its surfaces that tell whether a camera's pose is right."""


class KnownScene:
    """A map's distances, kept in a grid of nodes once somebody has asked.

    A camera that stands still sees the same places in every image, and one that
    moves hardly others than in the image before. So a map of any kind costs a
    look into a table. Nodes that were asked are never asked again: a scene is
    that of one version of the map.

    Args:
        field: The map; space that is only unknown is no part of it. None: there
            is nothing.
        config: The box of the grid.
        surface_W: Points on the map's surfaces in W, shape (n, 3) [m], see
            `surface_points`; none: no camera's pose can be doubted.

    Attributes:
        revision: Name of the map's content.
        surface_W: A selection of the points.
        nodes: Distance at each node, see `kernels.scan`, uint8.
        lower: Position of the first node, shape (3,) [m].
    """

    def __init__(
        self,
        field: DistanceField | None,
        config: SightConfig,
        surface_W: np.ndarray | None = None,
    ):
        self._field = None if field is None else field.surfaces
        if self._field is not None and not self._field.is_lipschitz:
            # Depth views of a point take as long as hundreds of distances.
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
        """Returns how far points (n, 3) are from the map, to a node's size [m].

        Points outside of the box are far.
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
        """Measures the distances of nodes, and keeps them.

        Args:
            asked: Flat indices of the nodes, shape (n,).
        """
        places = np.stack(np.unravel_index(asked, self.nodes.shape), axis=1)
        p_W = self.lower + NODE * places
        distance = self._distances(p_W)
        steps = np.clip(np.rint(distance / STEP), 0, FAR)
        self.nodes.reshape(-1)[asked] = steps.astype(np.uint8)

    def prepare_as(self, other: "KnownScene") -> None:
        """Measures the nodes that somebody has asked another map for.

        In small portions: other threads have their turn in between.

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
        splat_W: The splat, in W; None for none.
        truth: Solids, of which the faces count; None for none.
    """
    points = [np.zeros((0, 3))]
    if splat_W is not None:
        opaque = splat_W.opacities > 0.5
        points.append(splat_W.p_GK[opaque].astype(float))
    if truth is not None:
        points.extend(_faces(truth))
    return np.concatenate(points)


def _faces(scene: PrimitiveScene) -> list[np.ndarray]:
    """Points on the solids, evenly over each."""
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
