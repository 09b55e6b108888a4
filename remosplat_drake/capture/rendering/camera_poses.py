"""Chooses camera poses from which a scene is captured."""

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField

RADIUS = 2.0
"""Radius of the part of a scene in which a robot's task takes place [m]."""

CLEARANCE = 0.12
"""Least distance of a camera from every solid [m]."""

_CANDIDATES = 12
_MAX_REJECTED = 300
"""The search fails if this many consecutive candidates are inside or near
solids.
"""


def look_at(p_WC: np.ndarray, p_WT: np.ndarray) -> RigidTransform:
    """Returns the pose X_WC of an upright camera that looks at a point T.

    Args:
        p_WC: Position of the camera in W, shape (3,) [m].
        p_WT: Point to look at in W, shape (3,) [m].
    """
    z_W = (p_WT - p_WC) / np.linalg.norm(p_WT - p_WC)
    x_W = np.cross(z_W, [0, 0, 1])
    if np.linalg.norm(x_W) < 1e-6:
        x_W = np.array([1.0, 0, 0])
    x_W = x_W / np.linalg.norm(x_W)
    R_WC = np.column_stack([x_W, np.cross(z_W, x_W), z_W])
    return RigidTransform(RotationMatrix(R_WC), p_WC)


def survey(
    field: DistanceField,
    focus: np.ndarray,
    n: int = 120,
    seed: int = 0,
    radius: float = RADIUS,
    clearance: float = CLEARANCE,
    lowest: float = -np.inf,
) -> list[RigidTransform]:
    """Chooses camera poses X_WC that see a scene around a point from all sides.

    A quarter of the cameras are distant. Each of the remaining cameras faces a
    surface point near the focus, including points below table tops and inside
    shelves. Mitchell's best-candidate sampling spreads the cameras.

    Args:
        field: Signed distances to the scene.
        focus: The point in W, shape (3,) [m].
        n: Number of poses.
        seed: Seed of the random choice.
        radius: Horizontal distance of the farthest cameras from the focus [m];
            all other lengths except the clearance are proportional to it.
        clearance: Least distance of a camera from every solid [m].
        lowest: Least height of a camera [m], for example the height of the
            floor.

    Raises:
        RemoSplatError: Not enough free camera positions are found.
    """
    rng = np.random.default_rng(seed)
    poses: list[RigidTransform] = []
    rejected = 0
    while len(poses) < n:
        draw = _draw_far if len(poses) < n // 4 else _draw_near
        views = [draw(focus, radius, field, rng) for _ in range(_CANDIDATES)]
        p_WC = np.array([view[0] for view in views])
        free = field.clearances(Spheres.at(p_WC)).per_sphere(_CANDIDATES)
        placed = np.array([pose.translation() for pose in poses])
        apart = np.linalg.norm(p_WC[:, None] - placed.reshape(1, -1, 3), axis=2)
        nearest = apart.min(axis=1, initial=5 * radius)
        allowed = (free > clearance) & (p_WC[:, 2] >= lowest)
        score = np.where(allowed, nearest, -1)
        rejected = 0 if score.max() > 0 else rejected + 1
        if rejected == 0:
            poses.append(look_at(*views[int(score.argmax())]))
        elif rejected == _MAX_REJECTED:
            x, y, z = focus
            raise RemoSplatError(
                f"found room for only {len(poses)} of {n} cameras within"
                f" {radius:g} m of ({x:.3g}, {y:.3g}, {z:.3g}); choose another"
                " point or radius"
            )
    return poses


def _draw_far(
    focus: np.ndarray,
    radius: float,
    field: DistanceField,
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """Draws a camera centre around the scene, and a point to look at."""
    del field  # The position does not depend on it.
    azimuth = rng.uniform(-np.pi, np.pi)
    side = np.array([np.cos(azimuth), np.sin(azimuth), 0])
    away = radius * rng.uniform(0.65, 1.0)
    up = radius * rng.uniform(-0.1, 0.7)
    p_WT = focus + radius * rng.normal(0, 0.15, 3)
    return focus + away * side + [0, 0, up], p_WT


def _draw_near(
    focus: np.ndarray,
    radius: float,
    field: DistanceField,
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """Draws a camera centre in front of a surface point, and this point."""
    start = focus + radius * rng.uniform(-1, 1, 3) * [0.4, 0.45, 0.35]
    surface = field.clearances(Spheres.at(start))
    back = radius * rng.uniform(0.175, 0.35) * surface.direction_W[0]
    p_WT = surface.p_WC[0]
    return p_WT - back + radius * rng.normal(0, 0.1, 3), p_WT
