"""`MappingJob`: what a mapping process works at, and how it makes a map."""

import dataclasses as dc
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

from remosplat_drake.camera.wrist_camera import WristCamera
from remosplat_drake.capture.capture import Capture
from remosplat_drake.mapping.map_builder import build_map
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.mapping.store.map_file import write_map
from remosplat_drake.mapping.store.session import Session, Version
from remosplat_drake.reconstruction.pipeline import Report
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.splat.gaussian_splat import GaussianSplat


@dc.dataclass(frozen=True)
class WrittenMap:
    """A map that has just been written.

    Attributes:
        version: What the session notes about it.
        seal: That of its file; see `write_map`.
    """

    version: Version
    seal: str


@dc.dataclass(frozen=True, eq=False)
class MappingJob:
    """What a mapping process works at; it can be sent to another process.

    Attributes:
        session: The session's folder.
        config: How maps are made.
        robot: The robot that carries the camera.
        make_camera: Makes the camera, inside the process.
        make_field: The oracle's field of a splat.
        q0: Where the robot stands at the start, shape (n_q,): the space
            around it has been looked at, see `MappingConfig.start_margin`.
        base: What the scenario's map begins with, if it is a splat.
    """

    session: Path
    config: MappingConfig
    robot: RobotModel
    make_camera: Callable[[], WristCamera]
    make_field: Callable[[GaussianSplat], DistanceField]
    q0: np.ndarray
    base: GaussianSplat | None = None


def next_map(
    job: MappingJob,
    session: Session,
    names: tuple[str, ...],
    capture: Capture,
    effort: str,
) -> Callable[[Report], WrittenMap]:
    """What makes and writes the next map of a session; it may take long.

    It takes what it needs from the session here and now, so that it can run
    in a thread.

    Args:
        job: How maps are made.
        session: Which map is next.
        names: Of the frames.
        capture: The frames.
        effort: "quick" or "full".
    """
    build = partial(
        build_map,
        capture,
        job.config,
        version=session.next_version,
        parent=session.head,
        frames=names,
        time=session.frames.time(names[-1]),
        make_field=job.make_field,
        effort=effort,
        base=job.base,
        robot_free=free_around(job, session.frames.places(names)),
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
    """Balls without an obstacle: the robot in n configurations (n, n_q).

    At the start they are larger, so that what the robot may not see of
    itself does not become an obstacle with the first map.
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
