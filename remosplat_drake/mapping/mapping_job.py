"""`MappingJob`: the inputs of a mapping process, and how it builds a map."""

import dataclasses as dc
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

from remosplat_drake.camera.wrist_camera import WristCamera
from remosplat_drake.capture.capture import Capture
from remosplat_drake.mapping.camera_suspicion import Judgement, judge_camera
from remosplat_drake.mapping.map_builder import build_map, within
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.mapping.store.map_file import write_map
from remosplat_drake.mapping.store.session import Session, Version
from remosplat_drake.reconstruction.pipeline import Report
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.placed_object import PlacedObject
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.signals.coverage import Coverage
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.splat.gaussian_splat import GaussianSplat


@dc.dataclass(frozen=True)
class WrittenMap:
    """A map that has just been built and written to its file.

    Attributes:
        version: The session's record of the map.
        seal: The file's seal, from `write_map`, with which the control process
            opens the file without checks.
    """

    version: Version
    seal: str


@dc.dataclass(frozen=True, eq=False)
class MappingJob:
    """The inputs of a mapping process, which can be pickled.

    Attributes:
        session: Folder of the session.
        config: Settings of the live map.
        robot: The robot that carries the camera.
        make_camera: Function that makes the camera; called in the mapping
            process.
        make_field: Function that makes the oracle's distance field from a
            splat.
        q0: Initial configuration, shape (n_q,). An operator has checked the
            space around it, see `MappingConfig.start_margin`.
        base: The splat of the scenario; None if it has none.
        base_seen: The seen space of the capture of `base`, as `in_box` returns
            it; None if unknown.
        unseen_is_solid: Whether unseen space is an obstacle in the maps.
        objects: The objects of an operator's jobs, which the maps do not
            contain. Each frame contains their poses.
    """

    session: Path
    config: MappingConfig
    robot: RobotModel
    make_camera: Callable[[], WristCamera]
    make_field: Callable[[GaussianSplat], DistanceField]
    q0: np.ndarray
    base: GaussianSplat | None = None
    base_seen: Coverage | None = None
    unseen_is_solid: bool = False
    objects: tuple[SceneObject, ...] = ()


@dc.dataclass(frozen=True, eq=False)
class UsableFrames:
    """The frames of the next map, with their poses.

    Attributes:
        names: Names of the frames.
        capture: The frames, in W.
        q: The robot's configurations in W, shape (n, n_q).
        residual: Median distance of each frame's surfaces from those of other
            frames, shape (n,) [m]; NaN if not measured.
        objects: The known objects at each frame.
    """

    names: tuple[str, ...]
    capture: Capture
    q: np.ndarray
    residual: np.ndarray
    objects: tuple[tuple[PlacedObject, ...], ...]

    def select(self, index: np.ndarray) -> "UsableFrames":
        """Returns the frames with the given indices."""
        return UsableFrames(
            tuple(self.names[i] for i in index),
            self.capture.select(index),
            self.q[index],
            self.residual[index],
            tuple(self.objects[i] for i in index),
        )


def next_judgement(
    job: MappingJob, frames: UsableFrames
) -> Callable[[Report], Judgement]:
    """Prepares an estimate of the camera's errors from the frames.

    Returns:
        A function that computes the estimate without access to the session, so
        that it can run in a thread.
    """
    return lambda report: judge_camera(
        within(frames.capture, job.config.max_depth),
        frames.names,
        drifts=job.config.corrects_base,
        report=report,
    )


def next_map(
    job: MappingJob,
    session: Session,
    frames: UsableFrames,
    effort: str,
    camera: str = "",
) -> Callable[[Report], WrittenMap]:
    """Prepares the next map of a session.

    Args:
        job: The inputs of the mapping process.
        session: The session that the map belongs to.
        frames: The frames.
        effort: "quick" or "full".
        camera: Description of the camera errors that were corrected.

    Returns:
        A function that builds the map and writes its file. It may take long,
        but does not access the session, so that it can run in a thread.
    """
    build = partial(
        build_map,
        frames.capture,
        job.config,
        version=session.next_version,
        parent=session.head,
        frames=frames.names,
        time=session.frames.time(frames.names[-1]),
        make_field=job.make_field,
        effort=effort,
        base=job.base,
        base_seen=job.base_seen,
        unseen_is_solid=job.unseen_is_solid,
        robot_free=free_around(job, frames.q),
        camera=camera,
        objects=frames.objects,
        things=job.objects,
    )
    return partial(_make, build, session.map_path(session.next_version))


def _make(
    build: Callable[..., SceneMap], path: Path, report: Report
) -> WrittenMap:
    start = perf_counter()
    scene_map = build(report=report)
    seal = write_map(path, scene_map)
    version = Version(
        version=scene_map.version,
        parent=scene_map.parent or 0,
        file=f"{path.parent.name}/{path.name}",
        frames=scene_map.frames,
        seconds=perf_counter() - start,
    )
    return WrittenMap(version, seal)


def free_around(job: MappingJob, q: np.ndarray) -> Spheres:
    """Returns balls of free space in which the robot has been.

    The balls at the initial configuration are larger, so that space that the
    robot itself occludes does not become an obstacle in the first map.

    Args:
        job: Inputs of the mapping process: robot, initial configuration and
            margins.
        q: Later configurations of the robot, shape (n, n_q).
    """
    start = job.robot.spheres_at(job.q0)
    more = max(0.0, job.config.start_margin - job.config.robot_margin)
    places = [
        dc.replace(start, radius=start.radius + more),
        *(job.robot.spheres_at(each) for each in q),
    ]
    return Spheres(
        *(
            np.concatenate([getattr(place, field.name) for place in places])
            for field in dc.fields(Spheres)
        )
    )
