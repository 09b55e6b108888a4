"""`ViewStack`: arrays of the planes and sampled points of many views."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.camera_errors import velocity_C
from remosplat_drake.reconstruction.alignment.plane_maps import (
    PlaneMap,
    plane_map,
)

SAMPLES = 600
"""Number of points of a view that are compared with other views."""


class ViewStack(NamedTuple):
    """Arrays of the planes, points and cameras of n views, for the kernels.

    Attributes:
        plane: The views' `PlaneMap.plane`, (n, rows, columns, 4), float32.
        camera: f_x, f_y, c_x, c_y of each view, (n, 4) [pixels].
        height: Height of each view's image, (n,) [pixels].
        velocity_C: Each camera's velocity in its own frame, angular and of its
            centre, (n, 6) [rad/s, m/s]; 0 where unknown.
        step: Distance of the lattice's points [pixels].
        deviation: `PlaneMap.deviation` of each view, (n,) [1/m].
        tilt: `PlaneMap.tilt` of each view, (n,) [rad].
        independent: `PlaneMap.independent` of each view, (n,).
        point: Sampled points in C, (n, s, 3) [m].
        normal: Normals at the sampled points, in C, (n, s, 3).
        count: Number of each view's samples that are used, (n,).
    """

    plane: np.ndarray
    camera: np.ndarray
    height: np.ndarray
    velocity_C: np.ndarray
    step: int
    deviation: np.ndarray
    tilt: np.ndarray
    independent: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    count: np.ndarray


def stack_views(
    capture: Capture, samples: int = SAMPLES, seed: int = 0
) -> ViewStack:
    """Fits planes to all views of a capture, and samples their points."""
    stack = empty_stack(len(capture), capture.size, samples)
    for view in range(len(capture)):
        planes = plane_map(capture.K[view], capture.depth[view])
        rng = np.random.default_rng([seed, view])
        put_view(stack, view, planes, rng)
        stack.velocity_C[view] = velocity_C(capture, view)
    return stack


def empty_stack(n: int, size: tuple[int, int], samples: int) -> ViewStack:
    """Allocates arrays for n views with images of one size (height, width)."""
    shape = plane_map(np.eye(3), np.zeros(size, np.float32))
    return ViewStack(
        plane=np.zeros((n, *shape.plane.shape), np.float32),
        camera=np.zeros((n, 4)),
        height=np.full(n, float(size[0])),
        velocity_C=np.zeros((n, 6)),
        step=shape.step,
        deviation=np.zeros(n),
        tilt=np.zeros(n),
        independent=np.zeros(n),
        point=np.zeros((n, samples, 3)),
        normal=np.zeros((n, samples, 3)),
        count=np.zeros(n, np.int64),
    )


def put_view(
    stack: ViewStack, view: int, planes: PlaneMap, rng: np.random.Generator
):
    """Writes a view's planes and a random sample of its points to the stack."""
    stack.plane[view] = planes.plane
    stack.camera[view] = planes.camera
    stack.deviation[view] = planes.deviation
    stack.tilt[view] = planes.tilt
    stack.independent[view] = planes.independent
    row, column = np.nonzero(planes.plane[..., 3])
    chosen = _spread(planes.plane[row, column, :3], stack.point.shape[1], rng)
    row, column = row[chosen], column[chosen]
    fx, fy, cx, cy = planes.camera
    plane = planes.plane[row, column].astype(float)
    x = (column * planes.step + 0.5 - cx) / fx
    y = (row * planes.step + 0.5 - cy) / fy
    ray = np.stack([x, y, np.ones(len(x))], axis=1)
    z = plane[:, 3] / (plane[:, :3] * ray).sum(axis=1)
    stack.count[view] = len(chosen)
    stack.point[view, : len(chosen)] = z[:, None] * ray
    stack.normal[view, : len(chosen)] = plane[:, :3]


def _spread(
    normal: np.ndarray, samples: int, rng: np.random.Generator
) -> np.ndarray:
    """Draws indices whose normals are spread over all directions.

    Rare directions constrain motions that frequent directions do not
    (Rusinkiewicz and Levoy, "Efficient variants of the ICP algorithm", 2001).
    So each class of directions is drawn in proportion to the square root of its
    size.
    """
    if len(normal) <= samples:
        return np.arange(len(normal))
    cell = np.rint(1.5 * normal).astype(int) @ [1, 5, 25]
    _, kind, number = np.unique(cell, return_inverse=True, return_counts=True)
    chance = number[kind] ** -0.5
    return rng.choice(
        len(normal), samples, replace=False, p=chance / chance.sum()
    )
