"""Refines a splat without a GPU, by fitting surfels to all depth images.

Depth images measure surfaces directly, so a splat that is used for distances
can be optimised without rendering. Sweeps over the views move every surfel
along its normal onto the plane that best fits the depth of all views (moving
least squares with robust weights). Then the discs are cut off at edges of the
surfaces, and discs in free space are removed. A disc's colour is a robust mean
of the pixels around it.
"""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.threads import blocks, in_parallel
from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.surfels.seen_through import (
    drop_floaters,
    fill_holes,
)
from remosplat_drake.reconstruction.surfels.surfel_extent import (
    Extents,
    find_extents,
    fit_discs,
)
from remosplat_drake.reconstruction.surfels.surfel_gathering import (
    COLOR_SUMS,
    GRID,
    PLANE_SUMS,
    DepthNoise,
    DepthView,
    Patches,
    gather_planes,
    gather_votes,
    make_view,
)
from remosplat_drake.reconstruction.surfels.surfel_thinning import (
    uncrowded,
    with_spacing,
)
from remosplat_drake.reconstruction.surfels.surfels import (
    Surfels,
    quaternions_onto,
    splat_of_surfels,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.quaternions import rotation_matrices

_LEAST_NOISE = 1e-4
"""Least assumed standard deviation of depth [m]."""

_CHUNK = 30_000
"""Number of surfels whose votes are in memory at the same time (47 MB)."""

_PIECE = 5_000
"""Number of surfels that a thread processes at a time."""


@dc.dataclass
class RefinementConfig:
    """Settings of `refine`."""

    # Largest number of sweeps over all views.
    sweeps: int = 8
    # Sweeps end when 99 % of the surfels move by less than this length [m].
    converged: float = 2e-4
    # Distance from a surface up to which points belong to it regardless of
    # their noise, in the first sweep and in the last one [m]. Each sweep halves
    # it.
    tolerance: tuple[float, float] = (0.012, 0.0015)
    # Radius of the window around a surfel, as a multiple of its spacing.
    window: float = 1.6
    # Least and largest radius of a window [m].
    window_limits: tuple[float, float] = (0.01, 0.05)
    # Initial model of the depth's standard deviation: its value near the camera
    # [m], and its growth with z^2 [1/m]. A common factor of both numbers is
    # then estimated from the capture.
    noise: tuple[float, float] = (1e-3, 2e-3)
    # Least cosine of the angle of incidence at which a view sees a surfel.
    min_cosine: float = 0.1
    # Standard deviation of a disc as a multiple of its surfel's spacing.
    scale: float = 0.62
    # A surfel is removed if a surfel with more information is nearer than this
    # fraction of its spacing.
    crowding: float = 0.35
    # Opacity of a disc that many views confirm.
    opacity: float = 0.95


def refine(
    capture: Capture,
    surfels: Surfels,
    config: RefinementConfig | None = None,
    report: Callable[[int, int], None] | None = None,
) -> GaussianSplat:
    """Fits discs to all depth images of a capture, on the CPU.

    The result is deterministic. 60,000 surfels and 30 views of 480 x 360 take a
    few seconds.

    Args:
        capture: Posed RGB-D images.
        surfels: Surfels that determine the initial discs.
        config: Settings; None: the defaults.
        report: Called after every view with the number of views that have been
            processed, over all sweeps, and the largest possible number.

    Returns:
        The splat, in the capture's world frame.

    Raises:
        RemoSplatError: No view has a depth at any surfel.
    """
    config = config or RefinementConfig()
    first = splat_of_surfels(surfels, config.scale, config.opacity)
    progress = _Progress(capture, len(surfels), config, report)
    noise = DepthNoise(*config.noise, config.min_cosine, 0.1)
    tolerance, last = config.tolerance
    for _ in range(config.sweeps):
        surfels, step, excess, weight = _sweep(
            capture, surfels, noise, tolerance, config, progress
        )
        finest = tolerance <= last
        noise = _rescaled(noise, excess)
        tolerance = max(last, tolerance / 2)
        if finest and np.percentile(step, 99) < config.converged:
            break
    kept = uncrowded(surfels, weight, config.crowding)
    surfels = with_spacing(surfels, kept)
    splat = _cut_to_shape(capture, surfels, noise, last, config, progress)
    return fill_holes(capture, drop_floaters(capture, splat), first)


class _Progress:
    """Reports the number of views that were processed, over all sweeps."""

    def __init__(self, capture, count, config, report):
        chunks = -(-count // _CHUNK)
        self._total = len(capture) * (config.sweeps + chunks)
        self._report = report
        self._done = 0

    def step(self):
        self._done += 1
        if self._report is not None:
            self._report(self._done, self._total)


def _sweep(
    capture: Capture,
    surfels: Surfels,
    noise: DepthNoise,
    tolerance: float,
    config: RefinementConfig,
    progress: _Progress,
) -> tuple[Surfels, np.ndarray, float, np.ndarray]:
    """Moves the surfels onto the planes of their surroundings.

    Returns:
        The surfels, the distance by which each one moved, (n,) [m], the ratio
        of actual to assumed noise, and the weight of each surfel, (n,).
    """
    patches = _patches(surfels, config)
    planes = np.zeros((len(surfels), PLANE_SUMS))
    colors = np.zeros((len(surfels), COLOR_SUMS))
    for i in range(len(capture)):
        view = make_view(capture, i)
        _share(gather_planes, patches, view, noise, tolerance, planes, colors)
        progress.step()
    weight = planes[:, 0]
    seen = weight > 0
    if not seen.any():
        raise RemoSplatError("no view has a depth at any surfel")
    height, slope = _fit_planes(planes, patches.radius)
    x_W, y_W, z_W = patches.R_WK.transpose(2, 0, 1)
    normal_W = z_W - slope[:, :1] * x_W - slope[:, 1:] * y_W
    normal_W /= np.linalg.norm(normal_W, axis=1, keepdims=True)
    known = colors[:, 3:] > 0
    color = colors[:, :3] / np.where(known, colors[:, 3:], 1)
    moved = dc.replace(
        surfels,
        p_WK=surfels.p_WK + height[:, None] * z_W,
        normal_W=normal_W,
        colors=np.where(known, color, surfels.colors),
    )
    excess = np.sqrt(np.median(planes[seen, 9] / weight[seen]))
    return moved, np.abs(height), float(excess), weight


def _fit_planes(
    planes: np.ndarray, radius: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Fits planes: heights over the centres, (n,) [m], and slopes, (n, 2)."""
    sums = planes / np.maximum(planes[:, :1], 1e-30)
    normal_matrix = sums[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)
    # A small regularization, for windows whose points lie on one line.
    stiffness = 1e-3 * radius**2
    normal_matrix[:, 0, 0] = 1
    normal_matrix[:, 1, 1] += stiffness
    normal_matrix[:, 2, 2] += stiffness
    solution = np.linalg.solve(normal_matrix, sums[:, 6:9, None])[..., 0]
    height = np.clip(solution[:, 0], -radius, radius)
    return height, np.clip(solution[:, 1:], -1, 1)


def _rescaled(noise: DepthNoise, excess: float) -> DepthNoise:
    """The noise model, scaled to explain the residuals of a sweep."""
    return noise._replace(
        floor=noise.floor * excess + _LEAST_NOISE,
        growth=noise.growth * excess,
    )


def _cut_to_shape(
    capture: Capture,
    surfels: Surfels,
    noise: DepthNoise,
    tolerance: float,
    config: RefinementConfig,
    progress: _Progress,
) -> GaussianSplat:
    """Cuts discs off at edges, and removes discs in free space."""
    patches = _patches(surfels, config)
    parts = [
        part
        for rows in blocks(len(surfels), _CHUNK)
        for part in _extents(
            capture,
            Patches(*(array[rows] for array in patches)),
            noise,
            tolerance,
            progress,
        )
    ]
    extents = Extents(
        *(
            np.concatenate([getattr(part, field.name) for part in parts])
            for field in dc.fields(Extents)
        )
    )
    p_WK, R_WK, scales = fit_discs(
        extents, patches.p_WK, patches.R_WK, config.scale * surfels.spacing
    )
    # A disc that views confirm is opaque; an unconfirmed disc is translucent.
    confidence = (extents.solid + 0.1) / (extents.solid + extents.free + 0.14)
    keep = (extents.solid >= extents.free) & (scales.min(axis=1) > 5e-4)
    return GaussianSplat(
        p_GK=p_WK[keep],
        quaternions=Rotation.from_matrix(R_WK[keep]).as_quat(scalar_first=True),
        scales=scales[keep],
        opacities=config.opacity * np.minimum(confidence, 1)[keep],
        colors=np.clip(surfels.colors[keep], 0, 1),
    )


def _extents(
    capture: Capture,
    patches: Patches,
    noise: DepthNoise,
    tolerance: float,
    progress: _Progress,
) -> list[Extents]:
    """The extents of all patches; threads compute groups of them."""
    solid, free = np.zeros((2, len(patches.p_WK), GRID, GRID), np.float32)
    for i in range(len(capture)):
        view = make_view(capture, i)
        _share(gather_votes, patches, view, noise, tolerance, solid, free)
        progress.step()
    return in_parallel(
        lambda rows: find_extents(
            solid[rows], free[rows], patches.radius[rows]
        ),
        blocks(len(solid), _PIECE),
    )


def _share(
    gather: Callable[..., object],
    patches: Patches,
    view: DepthView,
    noise: DepthNoise,
    tolerance: float,
    *sums: np.ndarray,
):
    """Computes the sums in threads, each of which has a part of the patches."""

    def gather_piece(rows: slice):
        own = Patches(*(array[rows] for array in patches))
        gather(own, view, noise, tolerance, *(array[rows] for array in sums))

    in_parallel(gather_piece, blocks(len(patches.p_WK), _PIECE))


def _patches(surfels: Surfels, config: RefinementConfig) -> Patches:
    return Patches(
        np.array(surfels.p_WK, float, order="C"),
        rotation_matrices(quaternions_onto(np.array(surfels.normal_W, float))),
        np.clip(config.window * surfels.spacing, *config.window_limits),
        np.array(surfels.colors, float, order="C"),
    )
