"""Computes the known part of space, from frames and the robot's positions."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.mapping.carving import find_rest
from remosplat_drake.mapping.changes import (
    Changes,
    coherent,
    points_at,
    seen_at,
    without,
)
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.reconstruction.measured_cells import (
    CELLS,
    measured_cells,
    without_measured,
)
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.reconstruction.seen_space import find_seen_space
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.coverage import (
    FREE,
    SURFACE,
    UNSEEN,
    Coverage,
    grid_shape,
    with_free,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_DEEPEST = 0.3
"""Objects on tables are assumed to have at most this size along a camera's ray
[m]."""


def known_space(
    capture: Capture,
    come: np.ndarray,
    measured: np.ndarray,
    splat_W: GaussianSplat,
    robot_free: Spheres | None,
    config: MappingConfig,
    before: Coverage | None = None,
) -> Coverage:
    """Classifies the voxels of the mapped box as surface, free or unseen.

    Space that was seen before remains known, except behind new objects. A voxel
    with a measured point is not free, unless the robot itself was in it.

    Args:
        capture: The frames that may mark space as free, without their outdated
            parts.
        come: Pixels that show objects that were not in older frames, shape (n,
            h, w), bool.
        measured: Voxels that contain measured points, see `measured_in_box`.
        splat_W: All surfaces, in W.
        robot_free: The robot's spheres at the configurations at which frames
            were taken; None if there are none.
        config: Settings, with the box, its voxels and the margin around the
            robot.
        before: The space that was seen before the frames, in the same voxels,
            as `in_box` returns it; None if nothing was seen.
    """
    coverage = find_seen_space(capture, splat_W, *_box(config), measured)
    if before is not None:
        come = come | _come_since(before, capture)
        unseen = coverage.state == UNSEEN
        state = np.where(unseen, before.state, coverage.state)
        coverage = dc.replace(coverage, state=state)
    coverage = _without_shadows(coverage, capture, come)
    if robot_free is not None:
        coverage = with_free(coverage, robot_free, config.robot_margin)
    coverage = without_measured(coverage, measured, capture)
    if robot_free is not None:
        coverage = with_free(coverage, robot_free, 0.0)
    return coverage


def measured_in_box(
    frames: Capture, changes: Changes, capture: Capture, config: MappingConfig
) -> np.ndarray:
    """Finds the cells of the mapped box that contain measured surface points.

    Args:
        frames: All frames as they were taken.
        changes: The outdated parts of these frames.
        capture: The frames that may mark space as free, without their outdated
            parts.
        config: Settings, with the box and its voxels.

    Returns:
        Indices of the cells, as `measured_cells` returns them.
    """
    lower, _, voxel = box = _box(config)
    cells = measured_cells(without(frames, changes.gone), *box)
    p_W = lower + voxel / CELLS * (cells + 0.5)
    gone_W = points_at(frames, changes.gone)
    return cells[~find_rest(p_W, gone_W, capture)]


def in_box(
    coverage: Coverage, X_WG: np.ndarray, config: MappingConfig
) -> Coverage:
    """Resamples a `Coverage` to the voxels of the mapped box.

    Args:
        coverage: The seen space, in voxels of a frame G.
        X_WG: Pose of G in the world W, shape (4, 4).
        config: Settings, with the box and its voxels, in W.

    Returns:
        The coverage of the box. A voxel is seen only if all voxels of
        `coverage` that it overlaps are seen.
    """
    nothing = _nothing_seen(config)
    places = np.indices(nothing.state.shape).reshape(3, -1).T
    count = int(np.ceil(config.voxel / coverage.voxel)) + 1
    steps = np.linspace(1e-6, 1 - 1e-6, count)
    seen = np.ones(len(places), bool)
    surface = np.zeros(len(places), bool)
    X_GW = np.linalg.inv(X_WG)
    for part in np.stack(np.meshgrid(steps, steps, steps), -1).reshape(-1, 3):
        p_W = nothing.lower + config.voxel * (places + part)
        state = coverage.states_at(p_W @ X_GW[:3, :3].T + X_GW[:3, 3])
        seen &= state != UNSEEN
        surface |= state == SURFACE
    state = np.where(seen, np.where(surface, SURFACE, FREE), UNSEEN)
    state = state.astype(np.uint8).reshape(nothing.state.shape)
    return dc.replace(nothing, state=state)


def space_around(robot: Spheres, config: MappingConfig) -> Coverage:
    """Returns the seen space before any frame: free space around the robot.

    Args:
        robot: The robot's spheres at the start.
        config: Settings, with the box, its voxels and the margin around the
            robot.
    """
    return with_free(_nothing_seen(config), robot, config.start_margin)


def _box(config: MappingConfig) -> tuple[np.ndarray, np.ndarray, float]:
    """Lower and upper corner of the mapped box, and the voxels' edge length."""
    lower, upper = config.volume_lower, config.volume_upper
    return np.array(lower, float), np.array(upper, float), config.voxel


def _nothing_seen(config: MappingConfig) -> Coverage:
    """The mapped box with unseen voxels only."""
    lower, upper, voxel = _box(config)
    shape = grid_shape(lower, upper, voxel)
    return Coverage(lower, voxel, np.full(shape, UNSEEN, np.uint8))


def _come_since(before: Coverage, capture: Capture) -> np.ndarray:
    """Finds wide regions of measured points in formerly free space.

    Returns:
        Their pixels, shape (n, h, w) bool.
    """
    come = np.zeros(capture.depth.shape, bool)
    for view, depth in enumerate(capture.depth):
        measured = depth > 0
        was_free = np.zeros(depth.shape, bool)
        p_W = capture.points_W(view)[measured]
        was_free[measured] = before.states_at(p_W) == FREE
        come[view] = coherent(was_free)
    return come


def _without_shadows(
    coverage: Coverage, capture: Capture, come: np.ndarray
) -> Coverage:
    """Marks formerly free space behind the faces of new objects as unseen.

    The extent of a new object behind its face is unknown until a view shows its
    back.
    """
    state = coverage.state.copy()
    for view in np.flatnonzero(come.any(axis=(1, 2))):
        voxels = np.argwhere(state == FREE)
        p_W = coverage.lower + coverage.voxel * (voxels + 0.5)
        index, row, column, z = seen_at(capture, p_W, int(view))
        behind = z - capture.depth[view, row, column]
        shadow = come[view, row, column] & (behind > 0) & (behind < _DEEPEST)
        index = index[shadow]
        since = capture.select(np.arange(view, len(capture)))
        seen = times_looked_through(since, p_W[index], coverage.voxel / 4) > 0
        state[tuple(voxels[index[~seen]].T)] = UNSEEN
    return dc.replace(coverage, state=state)
