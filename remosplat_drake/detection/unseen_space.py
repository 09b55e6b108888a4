"""`UnseenSpace`: space in which an object may be hidden from all cameras.

An object that is hidden in unseen space may come out of it. It can only be
where it could move without being seen. So the set of its possible positions is
tracked: in each step, the set expands as fast as objects may move, and
positions at which a camera shows free space are removed. The space behind the
robot, which moves with the robot through space that was seen as free, therefore
contains no hidden object.

The set consists of the voxels of a grid that may contain the centre of a hidden
ball of radius r. Let rho be half the diagonal of a voxel. A ball with its
centre in the voxel contains all points within r - rho of the voxel's middle.
Let v be the speed of hidden objects. If a camera has shown free space at the
middle within the last (r - rho) / v seconds, no such centre is in the voxel
now. The same holds if the middle is inside the robot, the map or the floor. A
hidden object is assumed to be a union of such balls, so it is within r of the
voxels that may contain their centres.
"""

import dataclasses as dc
import math
from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform
from scipy.ndimage import binary_dilation
from scipy.spatial import KDTree

from remosplat_drake.detection.depth_image import DepthImage
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.known_scene import KnownScene
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import Mover

UNSEEN = "unseen space"
"""Name of hypothetical movers in unseen space."""

VOXEL, RADIUS = 0.08, 0.1
"""Edge length of the voxels, and radius r of the hidden balls of which a hidden
object consists (see the module) [m]."""

START = 0.3
"""At the start, no object is hidden within this distance of the robot, since an
operator has checked this space [m].
"""

NEAR = 1.0
"""Hidden objects are reported within this distance of the robot's spheres [m].
"""

_LOOKED_AT = 1.2
"""Space farther than this from the robot is not checked, so it may always
contain hidden objects [m].
"""

MOST_BOXES = 100
"""At most this many boxes cover the possible positions; if more are needed,
boxes are merged.
"""

_REST = RADIUS - 0.5 * math.sqrt(3.0) * VOXEL
_LATEST = 0.75
"""The set of possible positions is expanded as soon as hidden objects may have
moved by this fraction of a voxel's edge.
"""


@dc.dataclass(frozen=True, eq=False)
class UnseenSpace:
    """Possible positions of hidden objects; a copy is the object itself.

    Attributes:
        time: Time of the state [s].
        holds: Mask of the voxels, in the box of `DetectionConfig`, that may
            contain the centre of a hidden ball, shape (nx, ny, nz).
        boxes: Boxes around those voxels that are near the robot: least and
            greatest corners in W, shape (k, 2, 3) [m].
    """

    time: float
    holds: np.ndarray
    boxes: np.ndarray

    def __deepcopy__(self, memo) -> "UnseenSpace":
        return self

    @staticmethod
    def first(
        spheres: Spheres, time: float, config: DetectionConfig
    ) -> "UnseenSpace":
        """Makes the initial state: all space except the robot's surroundings.

        Args:
            spheres: The robot's spheres in W.
            time: The present time [s].
            config: Settings, with the box of the voxels.
        """
        size = np.subtract(config.upper, config.lower)
        holds = np.ones(np.ceil(size / VOXEL).astype(int), bool)
        voxels = np.argwhere(holds)
        near = _within(_middles(voxels, config), spheres, START)
        holds[tuple(voxels[near].T)] = False
        return UnseenSpace(time, holds, np.zeros((0, 2, 3)))

    def after(
        self,
        images: Sequence[DepthImage],
        spheres: Spheres,
        scene: KnownScene,
        config: DetectionConfig,
    ) -> "UnseenSpace":
        """Expands the possible positions, and removes those in free space.

        Args:
            images: The cameras' latest images.
            spheres: The robot's spheres in W at the time of the newest image.
            scene: The map.
            config: Settings, with the speed of objects that may come out of
                unseen space.
        """
        speed = config.unseen_speed
        time = max(image.time for image in images)
        step = speed * (time - self.time)
        if step < _LATEST * VOXEL:
            return self
        holds = np.ones_like(self.holds)
        steps = math.ceil(step / VOXEL)
        region = _around(spheres, holds.shape, config)
        spread = binary_dilation(self.holds, np.ones((3, 3, 3)), steps)
        holds[region] = spread[region]
        voxels = np.argwhere(holds[region])
        voxels += [part.start for part in region]
        p_W = _middles(voxels, config)
        free = p_W[:, 2] < config.floor_height
        for image in images:
            if speed * (time - image.time) <= _REST:
                p_C, measured = image.depths_at(p_W)
                z = p_C[:, 2]
                free |= measured > z + config.margin(z)
        left = np.flatnonzero(~free)
        solid = _within(p_W[left], spheres, 0.0)
        solid |= scene.distances(p_W[left]) <= 0.0
        free[left] = solid
        holds[tuple(voxels[free].T)] = False
        near = ~free
        near[near] = _within(p_W[near], spheres, NEAR)
        lower, upper = _boxes(voxels[near])
        corner = np.array(config.lower)
        boxes = corner + VOXEL * np.stack([lower, upper], axis=1)
        return UnseenSpace(time, holds, boxes)

    def movers(self, time: float, config: DetectionConfig) -> list[Mover]:
        """Returns hidden objects that may approach the robot, as movers.

        Each has zero velocity, and may move in any direction at the speed
        `DetectionConfig.unseen_speed`.

        Args:
            time: The time of the movers [s].
            config: Settings, with the speed of objects that may come out of
                unseen space.
        """
        speed = config.unseen_speed
        return [
            Mover(
                UNSEEN,
                RigidTransform(0.5 * (lower + upper)),
                0.5 * (upper - lower),
                RADIUS,
                max_speed=speed,
                max_acceleration=0.0,
                velocity_error=speed,
                position_error=speed * max(time - self.time, 0.0),
            )
            for lower, upper in self.boxes
        ]


def _around(
    spheres: Spheres, shape: tuple[int, ...], config: DetectionConfig
) -> tuple[slice, ...]:
    """Returns indices of the voxels around the robot that are checked."""
    radius = np.asarray(spheres.radius)[:, None] + _LOOKED_AT
    lower = (np.asarray(spheres.p_WS) - radius).min(axis=0) - config.lower
    upper = (np.asarray(spheres.p_WS) + radius).max(axis=0) - config.lower
    first = np.clip(np.floor(lower / VOXEL).astype(int), 0, shape)
    last = np.clip(np.ceil(upper / VOXEL).astype(int), 0, shape)
    return tuple(slice(a, b) for a, b in zip(first, last, strict=True))


def _middles(voxels: np.ndarray, config: DetectionConfig) -> np.ndarray:
    """Returns middles of voxels in W, shape (n, 3) [m]."""
    return np.array(config.lower) + VOXEL * (voxels + 0.5)


def _within(p_W: np.ndarray, spheres: Spheres, distance: float) -> np.ndarray:
    """Returns which points are within a distance of spheres, (n,) bool."""
    found = np.zeros(len(p_W), bool)
    if not len(p_W):
        return found
    points = KDTree(p_W)
    reach = np.asarray(spheres.radius) + distance
    for near in points.query_ball_point(spheres.p_WS, reach):
        found[near] = True
    return found


def _boxes(voxels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Covers voxels with boxes, exactly or with larger ones.

    Args:
        voxels: Indices of voxels, shape (n, 3).

    Returns:
        The boxes' least and greatest corners in voxels, shape (k, 3) each, with
        k up to `MOST_BOXES`.
    """
    if not len(voxels):
        return voxels, voxels
    edge = 1
    while True:
        lower = np.unique(voxels // edge, axis=0)
        lower, upper = _joined(lower, lower + 1)
        if len(lower) <= MOST_BOXES:
            return edge * lower, edge * upper
        edge *= 2


def _joined(
    lower: np.ndarray, upper: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Merges boxes that share a face, along one axis after another."""
    for axis in (2, 1, 0):
        others = [c for c in range(3) if c != axis]
        sides = np.column_stack([lower[:, others], upper[:, others]])
        order = np.lexsort((lower[:, axis], *sides.T))
        lower, upper, sides = lower[order], upper[order], sides[order]
        begins = np.ones(len(lower), bool)
        begins[1:] = (sides[1:] != sides[:-1]).any(axis=1)
        begins[1:] |= lower[1:, axis] != upper[:-1, axis]
        first = np.flatnonzero(begins)
        last = np.append(first[1:], len(lower)) - 1
        lower, upper = lower[first], upper[last]
    return lower, upper
