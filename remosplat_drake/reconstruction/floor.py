"""Finds the floor of a capture, which determines the direction of gravity.

The frame of a handheld capture is often that of its first image. A mobile robot
needs a frame with z up and the floor at z = 0.
"""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.surfels.surfels import (
    Surfels,
    surfels_from_capture,
)

_SAMPLES = 20_000
"""Number of surfels. They are evenly spread, so the number of surfels on a
plane measures its area.
"""

_HYPOTHESES = 500
"""Number of random surfels whose tangent planes are tried as the floor."""

_TABLE = 0.2
"""A level surface is not a part of the floor if it is at least this high above
the floor [m].
"""


@dc.dataclass
class FloorConfig:
    """Thresholds that a plane must meet to count as the floor."""

    # Largest angle between the plane's normal and the upward direction [rad].
    # The upward direction is that in the capture's files, or else the mean
    # upward direction of the images.
    max_tilt: float = 0.9
    # A surfel belongs to the plane if it is at most this far from it [m].
    thickness: float = 0.02
    # A surfel belongs to the plane only if the angle between the normals of
    # both is at most this [rad].
    facing: float = 0.35
    # Least area of the floor [m^2].
    min_area: float = 0.3
    # Least median height of the cameras over the floor [m].
    min_camera_height: float = 0.25
    # At most this fraction of the seen surfaces may lie more than `depth`
    # beneath the plane.
    max_beneath: float = 0.05
    # Depth beneath the plane up to which surfaces are attributed to noise or
    # reflections [m].
    depth: float = 0.06
    # Seed of the random choice of hypotheses.
    seed: int = 0


@dc.dataclass(frozen=True, eq=False)
class Floor:
    """The floor F of a capture: a level plane at its bottom.

    Attributes:
        X_FW: Pose of the capture's frame W in the frame F with z up and the
            floor at z = 0. F's x axis is W's x axis, projected onto the floor,
            and F's origin is vertically below or above W's.
        area: Area of the seen part of the floor [m^2].
        rms: Root mean square of the heights of the floor's surfels [m].
        tilt: Angle between the floor's normal and the mean upward direction of
            the cameras [rad].
        beneath: Fraction of the seen surfaces that are beneath the floor.
        camera_height: Median height of the cameras over the floor [m].
    """

    X_FW: RigidTransform
    area: float
    rms: float
    tilt: float
    beneath: float
    camera_height: float

    def aligned(self, capture: Capture) -> Capture:
        """Returns the capture with camera poses expressed in the frame F."""
        return capture.expressed_in(self.X_FW.GetAsMatrix4())


def find_floor(capture: Capture, config: FloorConfig | None = None) -> Floor:
    """Finds the floor by RANSAC: a level plane with few surfaces beneath it.

    Each hypothesis is the tangent plane of one random surfel. The best one is
    fitted to its surfels by least squares, together with the largest level
    surface above it, because a near table determines gravity better than a
    distant floor. A table top is not taken as the floor if the capture shows a
    lower surface. If it shows none, a table top cannot be distinguished from a
    floor.

    Args:
        capture: Posed RGB-D images.
        config: Thresholds; None: the defaults.

    Raises:
        RemoSplatError: No plane meets the thresholds; the error states which
            threshold the best plane does not meet.
    """
    config = config or FloorConfig()
    surfels = surfels_from_capture(capture, _SAMPLES, stride=4)
    p_WC = capture.X_WC[:, :3, 3]
    up_W = _mean_upright(capture)
    level = surfels.normal_W @ up_W > np.cos(config.max_tilt)
    if not level.any():
        raise RemoSplatError("no floor: the capture shows no level surface")
    choice = np.flatnonzero(level)
    rng = np.random.default_rng(config.seed)
    if len(choice) > _HYPOTHESES:
        choice = rng.choice(choice, _HYPOTHESES, replace=False)
    planes = [
        (surfels.normal_W[i], -float(surfels.normal_W[i] @ surfels.p_WK[i]))
        for i in choice
    ]
    best = max(planes, key=lambda plane: _score(surfels, *plane, p_WC, config))
    for _ in range(3):
        best = _fitted(surfels, *best, config)
    return _judged(surfels, *best, up_W, p_WC, config)


def _mean_upright(capture: Capture) -> np.ndarray:
    """The upward direction in W, from the file or from the images."""
    if capture.up_W is not None:
        return np.array(capture.up_W)
    up_W = -capture.X_WC[:, :3, 1].mean(axis=0)
    length = np.linalg.norm(up_W)
    if length < 0.1:
        raise RemoSplatError(
            "no floor: the cameras' upright directions differ too much to"
            " determine the upward direction"
        )
    return up_W / length


def _inliers(
    surfels: Surfels, normal_W: np.ndarray, offset: float, config: FloorConfig
) -> np.ndarray:
    """Mask of the surfels of a plane n p + offset = 0."""
    near = np.abs(surfels.p_WK @ normal_W + offset) < config.thickness
    return near & (surfels.normal_W @ normal_W > np.cos(config.facing))


def _score(
    surfels: Surfels,
    normal_W: np.ndarray,
    offset: float,
    p_WC: np.ndarray,
    config: FloorConfig,
) -> float:
    """Scores a plane by its area and by the surfaces beneath it.

    An area beneath the plane counts twenty times as much as an area of the
    plane, so that a table top does not get a better score than the floor.
    """
    if np.median(p_WC @ normal_W + offset) < config.min_camera_height:
        return -np.inf
    beneath = surfels.p_WK @ normal_W + offset < -config.depth
    inliers = _inliers(surfels, normal_W, offset, config)
    return float(inliers.sum() - beneath.sum() / config.max_beneath)


def _fitted(
    surfels: Surfels, normal_W: np.ndarray, offset: float, config: FloorConfig
) -> tuple[np.ndarray, float]:
    """Fits the floor's normal to level surfaces, by least squares."""
    inliers = _inliers(surfels, normal_W, offset, config)
    if inliers.sum() < 3:
        return normal_W, offset
    mean = surfels.p_WK[inliers].mean(axis=0)
    parts = [surfels.p_WK[inliers] - mean]
    height = surfels.p_WK @ normal_W + offset
    level = surfels.normal_W @ normal_W > np.cos(config.facing)
    count, edges = np.histogram(
        height[level & (height > _TABLE)], bins=np.arange(_TABLE, 3.0, 0.02)
    )
    top = edges[count.argmax()] + 0.01
    table = _inliers(surfels, normal_W, offset - top, config)
    if (surfels.spacing[table] ** 2).sum() > config.min_area:
        parts.append(surfels.p_WK[table] - surfels.p_WK[table].mean(axis=0))
    fitted = np.linalg.svd(np.concatenate(parts), full_matrices=False)[2][2]
    fitted = fitted * np.sign(fitted @ normal_W)
    return fitted, -float(fitted @ mean)


def _judged(
    surfels: Surfels,
    normal_W: np.ndarray,
    offset: float,
    up_W: np.ndarray,
    p_WC: np.ndarray,
    config: FloorConfig,
) -> Floor:
    """Returns the floor; raises an error if the plane misses a threshold."""
    inliers = _inliers(surfels, normal_W, offset, config)
    height = surfels.p_WK @ normal_W + offset
    # A surface has one surfel per square of the surfels' spacing.
    area = float((surfels.spacing[inliers] ** 2).sum())
    beneath = float((height < -config.depth).mean())
    camera_height = float(np.median(p_WC @ normal_W + offset))
    tilt = float(np.arccos(np.clip(normal_W @ up_W, -1, 1)))
    for wrong, problem in (
        (area < config.min_area, f"is only {area:.2f} m^2"),
        (
            beneath > config.max_beneath,
            f"has {100 * beneath:.0f} % of the scene beneath it",
        ),
        (
            camera_height < config.min_camera_height,
            f"is only {camera_height:.2f} m below the cameras",
        ),
        (
            tilt > config.max_tilt,
            f"is tilted by {np.degrees(tilt):.0f} degrees from the cameras'"
            " upright",
        ),
    ):
        if wrong:
            raise RemoSplatError(f"no floor: the best level plane {problem}")
    return Floor(
        X_FW=floor_frame(normal_W, offset),
        area=area,
        rms=float(np.sqrt((height[inliers] ** 2).mean())),
        tilt=tilt,
        beneath=beneath,
        camera_height=camera_height,
    )


def floor_frame(normal_W: np.ndarray, offset: float) -> RigidTransform:
    """Makes the pose X_FW of W in the frame F of a floor n p + offset = 0.

    Args:
        normal_W: The floor's upward unit normal n, shape (3,).
        offset: Height of W's origin over the floor [m].

    Returns:
        The pose X_FW: F has z up and the floor at z = 0. Its x axis is W's x
        axis, projected onto the floor, and its origin is vertically below or
        above W's.
    """
    x_W = np.array([1.0, 0, 0])
    if abs(normal_W[0]) > 0.99:
        x_W = np.array([0, 1.0, 0])
    x_W = x_W - (x_W @ normal_W) * normal_W
    x_W /= np.linalg.norm(x_W)
    R_FW = np.stack([x_W, np.cross(normal_W, x_W), normal_W])
    return RigidTransform(RotationMatrix(R_FW), [0, 0, offset])
