"""Begins a session of teleoperation in a new folder, or continues one."""

import importlib.util
import logging
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

import numpy as np

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.scenario_text import scenario_text
from remosplat_drake.app.scene_config import OBSTACLE
from remosplat_drake.app.seen_space import seen_file
from remosplat_drake.app.stages.movers import tracks_of
from remosplat_drake.app.stages.teleoperation import Teleoperation
from remosplat_drake.app.world import World, true_scenes
from remosplat_drake.base.errors import FieldError, MissingExtraError
from remosplat_drake.camera.lcm_camera import LcmCamera
from remosplat_drake.camera.rendered_camera import RenderedCamera
from remosplat_drake.camera.wrist_camera import WristCamera
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.mapping.known_space import in_box, space_around
from remosplat_drake.mapping.mapping_job import MappingJob
from remosplat_drake.mapping.mapping_process import MappingProcess
from remosplat_drake.mapping.messages import Build
from remosplat_drake.mapping.store.map_file import VersionError, open_map
from remosplat_drake.mapping.store.run_folders import RUNS, new_run
from remosplat_drake.mapping.store.session import SESSION_FILE, Session
from remosplat_drake.oracle.oracle_config import GroundTruth, make_field
from remosplat_drake.oracle.unknown_space import unknown_space_field
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_tiles import make_tiles
from remosplat_drake.station.station_config import KinematicStation

_MAPPING_PACKAGES = ("open3d", "PIL")

_log = logging.getLogger(__name__)


def holds_session(folder: Path) -> bool:
    """Returns whether a folder contains a session.

    Args:
        folder: Any path.
    """
    return (folder / SESSION_FILE).is_file()


def check_mappable(scenario: Scenario) -> None:
    """Checks that a live map can be made, before other work starts.

    Args:
        scenario: A checked scenario.

    Raises:
        FieldError: The oracle measures no distances to a splat, or
            `scene.unknown` is `obstacle` and the seen space of the splat's
            cameras is unknown.
        MissingExtraError: A package that mapping needs is not installed.
    """
    if not scenario.mapping.enabled:
        return
    if isinstance(scenario.oracle, GroundTruth):
        raise FieldError(
            scenario.source,
            "oracle",
            "!GroundTruth cannot measure distances to a live map; set "
            "mapping.enabled to false",
        )
    scene = scenario.scene
    is_solid = scene.unknown == OBSTACLE and scene.splat
    if is_solid and seen_file(scenario) is None:
        raise FieldError(
            scenario.source,
            "scene.unknown",
            "`obstacle` needs the seen space of the splat's cameras: name "
            "its file in scene.seen, remove scene.splat, or set `free`",
        )
    if not all(map(importlib.util.find_spec, _MAPPING_PACKAGES)):
        raise MissingExtraError(
            "a live map (mapping.enabled)", "reconstruction"
        )


@contextmanager
def removed_on_failure(folder: Path) -> Iterator[None]:
    """Removes the new files of a session if the `with` block fails.

    Args:
        folder: Folder of the session; its earlier content is kept.
    """
    missing = [p for p in (folder, *folder.parents) if not p.exists()]
    before = set(_entries(folder))
    try:
        yield
    except BaseException:
        for path in _entries(folder):
            if path not in before:
                shutil.rmtree(path) if path.is_dir() else path.unlink()
        for path in missing:
            # Parent folders are removed only if empty: other programs may use
            # them.
            with suppress(OSError):
                path.rmdir()
        raise


def _entries(folder: Path) -> list[Path]:
    """Lists the content of a session's folder and of its runs' folders."""
    return [*folder.glob(f"{RUNS}/*"), *folder.glob("*")]


def open_teleoperation(
    scenario: Scenario, world: World, folder: Path, *, hardware: bool
) -> Teleoperation:
    """Begins or continues a session, and starts its mapping process.

    Args:
        scenario: A checked scenario. If the folder contains a session, it must
            be the scenario of that session.
        world: The content of the scenario's files.
        folder: Folder of the session; it may be new or empty, or contain a
            session to continue.
        hardware: Whether the camera belongs to a real robot.

    Returns:
        The inputs of a teleoperated diagram; close it at the end.

    Raises:
        RemoSplatError: The folder or a file cannot be used.
    """
    if holds_session(folder):
        session = Session.open(folder)
    else:
        name = scenario.name
        session = Session.create(folder, scenario_text(scenario, name))
    initial = _initial_map(scenario, world)
    if not scenario.mapping.enabled:
        return Teleoperation(new_run(folder), None, initial)
    job = MappingJob(
        session=folder,
        config=scenario.mapping,
        robot=world.robot,
        make_camera=camera_maker(scenario, world, hardware),
        make_field=partial(
            make_field, scenario.oracle, truth=None, where=scenario.source
        ),
        q0=world.q0,
        base=world.scene_splat_W or None,
        objects=world.objects,
        base_seen=initial.coverage if world.seen is not None else None,
        unseen_is_solid=scenario.scene.unknown == OBSTACLE,
    )
    reopened, problem = _reopened(session)
    teleoperation = Teleoperation(
        initial=initial,
        reopened=reopened,
        scenes=() if hardware else true_scenes(scenario, world),
        run=new_run(folder),
        mapping=MappingProcess(job),
    )
    if problem and teleoperation.mapping is not None:
        _log.warning(
            "%s; the map is made again from the session's frames", problem
        )
        teleoperation.mapping.request(Build())
    return teleoperation


def _reopened(session: Session) -> tuple[SceneMap | None, str]:
    """Opens the map of a continued session, or raises an error.

    Raises:
        RemoSplatError: The map's file is damaged.
    """
    if session.head_map is None:
        return None, ""
    try:
        return open_map(session.head_map), ""
    except VersionError as error:
        return None, str(error)


def _initial_map(scenario: Scenario, world: World) -> SceneMap:
    """Makes the scenario's own map, without the objects.

    If the scenario has no splat, all space except near the robot is an
    obstacle. The robot can then look around, but cannot drive into unseen
    space.
    """
    splat_W = world.scene_splat_W or GaussianSplat.empty()
    field, coverage = world.scene_field or world.field, None
    quality = f"the scenario's map, {len(splat_W)} discs"
    if scenario.mapping.enabled and not len(splat_W):
        spheres = world.robot.spheres_at(world.q0)
        coverage = space_around(spheres, scenario.mapping)
        field = unknown_space_field(coverage)
        quality = "none yet: scan first"
    elif scenario.mapping.enabled and world.seen is not None:
        seen = world.seen
        X_WG = seen.X_WG.GetAsMatrix4()
        coverage = in_box(seen.coverage, X_WG, scenario.mapping)
    return SceneMap(
        version=0,
        parent=None,
        frames=(),
        time=-np.inf,
        field=field,
        splat_W=splat_W,
        coverage=coverage,
        tiles=make_tiles(splat_W),
        quality=quality,
    )


def camera_maker(
    scenario: Scenario, world: World, hardware: bool
) -> Callable[[], WristCamera]:
    """Returns a function that makes the wrist camera and can be pickled.

    Args:
        scenario: The scenario.
        world: The content of the scenario's files.
        hardware: Whether the camera belongs to a real robot.
    """
    config = scenario.camera or WristCameraConfig()
    if hardware:
        return partial(LcmCamera, config, world.robot, scenario.hardware)
    camera = partial(
        RenderedCamera,
        config,
        world.robot,
        world.truth,
        tracks=tracks_of(scenario),
    )
    station = scenario.station
    if isinstance(station, KinematicStation):
        camera = partial(camera, odometry_drift=station.odometry_drift)
    return camera
