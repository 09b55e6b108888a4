"""`build_map`: builds a version of the map from camera frames."""

import dataclasses as dc
from collections.abc import Callable, Sequence
from time import perf_counter

import numpy as np

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.capture.capture import Capture
from remosplat_drake.mapping.base_splat import updated
from remosplat_drake.mapping.carving import find_rest
from remosplat_drake.mapping.changes import (
    Changes,
    find_changes,
    points_at,
    without,
)
from remosplat_drake.mapping.depth_specks import without_specks
from remosplat_drake.mapping.frame_choice import confirmed_frames
from remosplat_drake.mapping.known_objects import (
    Placed,
    find_own_pixels,
    with_known_insides,
)
from remosplat_drake.mapping.known_space import known_space, measured_in_box
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.unknown_space import unknown_space_field
from remosplat_drake.reconstruction.devices import CPU
from remosplat_drake.reconstruction.pipeline import Report, reconstruct
from remosplat_drake.reconstruction.surfels.point_cloud import (
    InitialisationConfig,
    initialise,
)
from remosplat_drake.reconstruction.surfels.refinement import RefinementConfig
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.signals.coverage import UNSEEN, Coverage
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_tiles import make_tiles

QUICK, FULL = "quick", "full"
EFFORTS = (QUICK, FULL)
"""Ways to build a map: a quick map is built while the operator waits; a full
one is trained if the device allows it.
"""

_QUICK_SWEEPS = 2
_QUICK_DISCS = 20_000
"""Number of refinement sweeps, and largest number of discs, of a quick map."""


def build_map(
    capture: Capture,
    config: MappingConfig,
    *,
    version: int,
    parent: int | None,
    frames: tuple[str, ...],
    time: float,
    make_field: Callable[[GaussianSplat], DistanceField],
    effort: str = QUICK,
    base: GaussianSplat | None = None,
    base_seen: Coverage | None = None,
    unseen_is_solid: bool = False,
    robot_free: Spheres | None = None,
    camera: str = "",
    things: Sequence[SceneObject] = (),
    objects: Placed = (),
    report: Report = lambda stage, done, total: None,
) -> SceneMap:
    """Builds a map from frames.

    If frames contradict each other, the newest one is used. The map also
    contains the surfaces of unconfirmed frames. But an unconfirmed frame does
    not mark space as free, since its pose may be wrong.

    Args:
        capture: The frames, oldest first, with the robot hidden.
        config: Settings of the live map.
        version: Number of the new map.
        parent: Number of the previous map; None if there is none.
        frames: Names of the frames.
        time: Time at which the newest frame was taken [s].
        make_field: Function that makes the oracle's distance field from a
            splat.
        effort: `QUICK` or `FULL`.
        base: An earlier splat that the frames update; None starts from an empty
            map.
        base_seen: The seen space of that splat, as `in_box` returns it; None if
            unknown.
        unseen_is_solid: Whether unseen space is an obstacle in the map.
        robot_free: The robot's spheres at the configurations at which frames
            were taken, which mark space as free; None if there are none.
        camera: Description of the camera errors that were corrected; empty if
            there are none.
        things: Known objects, which the map does not contain.
        objects: The poses of these objects at each frame; empty if there are
            none.
        report: Function that is called with the name of the stage, its number
            of completed steps, and its total number of steps.

    Raises:
        RemoSplatError: The frames show too little, or a setting is invalid.
    """
    if effort not in EFFORTS:
        raise RemoSplatError(unknown_name("effort", effort, EFFORTS))
    start = perf_counter()
    report("comparing frames", 0, 1)
    looks = without_specks(capture)
    # A single frame may have an error along the walls that it shares with the
    # earlier splat.
    confirmed = confirmed_frames(looks, base) & (len(looks) > 1)
    # Known objects are neither surfaces nor changes of the scene, but space in
    # front of them is free.
    own = find_own_pixels(capture, things, objects)
    scene = without(capture, own)
    changes = find_changes(without(looks, own), confirmed)
    report("comparing frames", 1, 1)
    looks = without(looks, changes.outdated).select(np.flatnonzero(confirmed))
    splat_W = _surfaces(scene, changes, looks, config, effort, report)
    if base is not None and len(base):
        splat_W = updated(base, splat_W, looks)
    report("finding what was seen", 0, 1)
    coverage = known_space(
        *(looks, changes.come[confirmed]),
        measured_in_box(scene, changes, looks, config),
        *(splat_W, robot_free, config, base_seen),
    )
    coverage = with_known_insides(coverage, things, objects)
    report("finding what was seen", 1, 1)
    field = make_field(splat_W)
    if unseen_is_solid:
        field = CompositeDistanceField([field, unknown_space_field(coverage)])
    tiles = make_tiles(splat_W)
    seconds = perf_counter() - start
    return SceneMap(
        version=version,
        parent=parent,
        frames=tuple(frames),
        time=time,
        field=field,
        splat_W=splat_W,
        coverage=coverage,
        tiles=tiles,
        quality=_describe(confirmed, splat_W, coverage, seconds, camera),
    )


def _surfaces(
    capture: Capture,
    changes: Changes,
    looks: Capture,
    config: MappingConfig,
    effort: str,
    report: Report,
) -> GaussianSplat:
    """Makes discs on all seen surfaces, and fits them to present surfaces.

    Discs of earlier surfaces that new objects hide are kept.

    Args:
        capture: The frames as they were taken.
        changes: Their outdated parts.
        looks: The confirmed frames, without their outdated parts and with small
            gaps filled. Only these mark space as free.
        config: Settings of the live map.
        effort: `QUICK` or `FULL`.
        report: Function that is called with the progress.
    """
    remembered = without(capture, changes.gone)
    present = without(capture, changes.outdated)
    count, sweeps, device = config.discs, RefinementConfig.sweeps, config.device
    if effort == QUICK:
        count, sweeps, device = min(count, _QUICK_DISCS), _QUICK_SWEEPS, CPU
    report("surfels", 0, 1)
    surfels = initialise(
        within(remembered, config.max_depth), InitialisationConfig(count=count)
    )
    splat_W = reconstruct(
        within(present, config.max_depth),
        device,
        surfels=surfels,
        refinement=RefinementConfig(sweeps=sweeps),
        looks=looks,
        bounded=True,
        report=report,
    ).splat
    gone_W = points_at(capture, changes.gone)
    return splat_W.select(~find_rest(splat_W.p_GK, gone_W, looks))


def within(capture: Capture, max_depth: float) -> Capture:
    """Makes depths beyond a largest depth [m] unknown."""
    near = capture.depth <= max_depth
    return dc.replace(capture, depth=capture.depth * near)


def _describe(
    confirmed: np.ndarray,
    splat: GaussianSplat,
    coverage: Coverage,
    seconds: float,
    camera: str,
) -> str:
    alone = np.count_nonzero(~confirmed)
    n = len(confirmed)
    frames = "1 frame" if n == 1 else f"{n} frames"
    if alone:
        frames += f" ({alone} unconfirmed, not used for free space)"
    discs = f"{len(splat) / 1000:.0f}k" if len(splat) > 999 else len(splat)
    unseen = 100 * coverage.fraction(UNSEEN)
    words = f"{frames}, {discs} discs, {unseen:.0f} % unseen, {seconds:.1f} s"
    return f"{words}; {camera}" if camera else words
