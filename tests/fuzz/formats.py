"""Every format of files that is read: how a good one is made, and is read."""

import dataclasses as dc
import itertools
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np

# The writers of other programs' files that the other tests use.
from capture import capture_writers as writers
from pydrake.math import RigidTransform
from splat.toy_splats import random_splat

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.base import resources
from remosplat_drake.benchmark.methods import METHODS_FILE, load_methods
from remosplat_drake.benchmark.motion_bench_maker import read_request
from remosplat_drake.capture.formats import read_capture
from remosplat_drake.capture.frames import Frame
from remosplat_drake.capture.rendering.synthetic import (
    render_capture,
    survey_poses,
)
from remosplat_drake.hardware.wire import packets
from remosplat_drake.hardware.wire.base import decode_base_status
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.hardware.wire.messages.pose_target import pose_target
from remosplat_drake.hardware.wire.messages.velocity_target import (
    velocity_target,
)
from remosplat_drake.mapping.store.map_file import open_map, write_map
from remosplat_drake.mapping.store.session import Session, Version
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.oracle.unknown_space import unknown_space_field
from remosplat_drake.reconstruction.report.quality_report import (
    DistanceErrors,
    QualityReport,
    read_report,
    write_report,
)
from remosplat_drake.recording.events import Event, EventWriter, read_events
from remosplat_drake.recording.run_log import RunLogWriter, read_log
from remosplat_drake.recording.tick_table import TickTable
from remosplat_drake.recording.trajectory import (
    load_trajectory,
    save_trajectory,
)
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.robot.visuals import load_visuals
from remosplat_drake.scene.planning_scene import read_planning_scene
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene, write_rmmi
from remosplat_drake.signals.coverage import Coverage
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.splat.codecs.compressed_ply import write_compressed_ply
from remosplat_drake.splat.codecs.ply import write_ply
from remosplat_drake.splat.codecs.spz import write_spz
from remosplat_drake.splat.formats import read_splat, write_splat
from remosplat_drake.teleop import trajectory_file
from remosplat_drake.teleop.target_stream import (
    decode_pose_target,
    decode_velocity_target,
)

_DATA = Path(__file__).resolve().parents[1] / "data"
_MBM = _DATA / "mbm" / "shelf_panda"
_SCENE = PrimitiveScene(
    boxes=(Box(RigidTransform([1, 0, 0.4]), np.array([0.3, 0.4, 0.03])),),
    cylinders=(Cylinder(RigidTransform([0.8, 0.1, 0.6]), 0.05, 0.2),),
    X_WE_target=RigidTransform([1, 0, 0.6]),
    X_WB_start=(0.0, 0.0, 0.0),
)


@dc.dataclass(frozen=True)
class Format:
    """One format of files.

    Attributes:
        make: Puts good files of it into an empty folder.
        read: Reads them; given the folder.
    """

    make: Callable[[Path], object]
    read: Callable[[Path], object]


def _splat(
    name: str, write: Callable, scales: int = 3, harmonics: int = 0
) -> Format:
    def make(folder: Path) -> None:
        write(folder / name, random_splat(scales, harmonics))

    return Format(make, lambda folder: read_splat(folder / name))


def _sog_folder(folder: Path) -> None:
    write_splat(folder / "s.sog", random_splat())
    shutil.unpack_archive(folder / "s.sog", folder, "zip")
    (folder / "s.sog").unlink()


def _ascii_ply(folder: Path) -> None:
    from plyfile import PlyData

    write_ply(folder / "s.ply", random_splat(2))
    document = PlyData.read(str(folder / "s.ply"), mmap=False)
    document.text = True
    document.write(str(folder / "s.ply"))


SPLATS = {
    "ply": _splat("s.ply", write_ply, harmonics=3),
    "ply-2dgs": _splat("s.ply", write_ply, scales=2),
    "ply-ascii": Format(_ascii_ply, lambda f: read_splat(f / "s.ply")),
    "compressed-ply": _splat(
        "s.compressed.ply", write_compressed_ply, harmonics=3
    ),
    "splat": _splat("s.splat", write_splat),
    "spz": _splat("s.spz", write_spz, harmonics=8),
    "spz-4": _splat("s.spz", lambda p, s: write_spz(p, s, 4), harmonics=3),
    "sog": _splat("s.sog", write_splat),
    "sog-folder": Format(_sog_folder, read_splat),
    "checkpoint": _splat("ckpt_0.pt", write_splat, harmonics=3),
}


def _capture(name: str, file: str = "", **options) -> Format:
    """What one of the other tests' writers writes, as small as can be."""

    def make(folder: Path) -> None:
        capture = render_capture(_SCENE, survey_poses(_SCENE, n=3), 24, 18)
        # The video's codec wants whole blocks.
        writers.WRITERS[name](folder / file, capture, **options)

    return Format(make, lambda folder: read_capture(folder / file))


_CONFIDENCE = np.full((18, 24), 2)

CAPTURES = {
    "nerfstudio": _capture("nerfstudio"),
    "instant-ngp": _capture("instant-ngp"),
    "record3d": _capture("record3d", "scan.r3d"),
    "record3d-export": _capture("record3d-export"),
    "stray-scanner": _capture("stray-scanner", confidence=_CONFIDENCE),
    "tum": _capture("tum"),
    "7-scenes": _capture("7-scenes"),
    "trajectory-log": _capture("trajectory-log"),
}


def _copied(path: Path, name: str = "") -> Callable[[Path], object]:
    return lambda folder: shutil.copy(path, folder / (name or path.name))


def _make_robot(folder: Path) -> None:
    for path in _DATA.glob("three_link*"):
        shutil.copy(path, folder)


def _make_quality(folder: Path) -> None:
    write_splat(folder / "s.ply", random_splat(n=1))
    errors = DistanceErrors("SphereToEllipsoid", "truth", 9, 0.001, 0.002)
    write_report(
        folder / "s.ply", QualityReport(distances=[errors], map_error=0.01)
    )


def _make_run_log(folder: Path) -> None:
    log = RunLogWriter(folder / "run.log", n_q=3, n_u=2, period=0.1)
    for k in range(5):
        report = TickReport.before_first(3, 2)
        report = dc.replace(report, time=0.1 * k, q=np.zeros(3))
        log.append(report, np.zeros(2))
    log.close()


def _make_events(folder: Path) -> None:
    events = EventWriter(folder / "events.jsonl")
    for k in range(5):
        events.append(Event(0.1 * k, "map", f"map {k}", k))
    events.close()


def _make_trajectory(folder: Path) -> None:
    ticks = TickTable(3, 2)
    for _ in range(4):
        ticks.append(TickReport.before_first(3, 2), np.zeros(2))
    path = folder / "trajectory.npz"
    save_trajectory(ticks.trajectory(np.zeros(3)), path)


def _make_pose_target(folder: Path) -> None:
    message = pose_target()
    message.quaternion = [1.0, 0.0, 0.0, 0.0]
    (folder / "packet").write_bytes(message.encode())


def _make_velocity_target(folder: Path) -> None:
    (folder / "packet").write_bytes(velocity_target().encode())


def _make_base_status(folder: Path) -> None:
    message = base_status()
    (folder / "packet").write_bytes(message.encode())


def _packet(decode: Callable[[bytes], object]) -> Callable[[Path], object]:
    """Reads a packet; that it is broken is an answer like another."""

    def read(folder: Path) -> object:
        packet = folder / "packet"
        data = packet.read_bytes() if packet.exists() else b""
        try:
            return decode(data)
        except packets.BrokenMessage as error:
            return error

    return read


def _some_map() -> SceneMap:
    splat = random_splat(2)
    # What cameras have seen, in part, of a few cells.
    state = np.ones((3, 4, 5), np.uint8)
    state[:, 2:] = 0
    coverage = Coverage(np.zeros(3), 0.25, state)
    return SceneMap(
        version=1,
        parent=0,
        frames=("frame 1",),
        time=1.0,
        field=CompositeDistanceField(
            [
                SphereToEllipsoidField(splat),
                DepthRasterizationField(splat, DepthSensor(far=2)),
                unknown_space_field(coverage),
            ]
        ),
        splat_W=splat,
        coverage=coverage,
    )


def _read_map(folder: Path) -> object:
    """A map is there to be asked; its spheres are near and far."""
    spheres = Spheres.at([[0, 0, 0.1], [90, -90, 9]], 0.05)
    return open_map(folder / "a.rsmap").field.clearances(spheres)


def _make_session(folder: Path) -> None:
    session = Session.create(folder / "session", "{}")
    capture = render_capture(_SCENE, survey_poses(_SCENE, n=2), 24, 18)
    for view in range(len(capture)):
        frame = Frame(
            name="a view",
            K=capture.K[view],
            X_WC=capture.X_WC[view],
            rgb=capture.rgb[view],
            depth=capture.depth[view],
            time=float(view),
        )
        session.activate(session.frames.add(frame, np.zeros(3)))
    file = session.map_path(1).relative_to(session.folder)
    version = Version(1, 0, str(file), tuple(session.active), 1.0)
    session.record(version, set())


def _read_session(folder: Path) -> object:
    session = Session.open(folder / "session")
    return session.frames.load(session.active)


def _load_all_scenarios(folder: Path) -> list:
    path = folder / "s.yaml"
    return [
        load_scenario(f"{path}:{name}") for name in ("TableReach", "TableTour")
    ]


OTHERS = {
    "rmmi": Format(
        lambda folder: write_rmmi(folder / "s.json", _SCENE),
        lambda folder: read_scene(folder / "s.json"),
    ),
    "robot": Format(
        _make_robot, lambda folder: load_robot(folder / "three_link.yaml")
    ),
    "visuals": Format(
        _copied(resources.models_dir() / "panda" / "visuals.yaml"),
        lambda folder: load_visuals(folder / "visuals.yaml"),
    ),
    "planning-scene": Format(
        _copied(_MBM / "scene0001.yaml"),
        lambda folder: read_planning_scene(folder / "scene0001.yaml"),
    ),
    "motion-request": Format(
        _copied(_MBM / "request0001.yaml"),
        lambda folder: read_request(
            folder / "request0001.yaml", ("panda_joint1", "panda_joint7")
        ),
    ),
    "quality-report": Format(
        _make_quality, lambda folder: read_report(folder / "s.ply")
    ),
    "run-log": Format(
        _make_run_log, lambda folder: read_log(folder / "run.log")
    ),
    "events": Format(
        _make_events, lambda folder: read_events(folder / "events.jsonl")
    ),
    "trajectory": Format(
        _make_trajectory,
        lambda folder: load_trajectory(folder / "trajectory.npz"),
    ),
    "operator-script": Format(
        _copied(resources.scenarios_dir() / "operators" / "push.yaml"),
        lambda folder: trajectory_file.load_operator_steps(
            folder / "push.yaml", ("over the table",), (_SCENE, _SCENE)
        ),
    ),
    "scenario": Format(
        _copied(resources.scenarios_dir() / "frankie.yaml", "s.yaml"),
        _load_all_scenarios,
    ),
    "map": Format(
        lambda folder: write_map(folder / "a.rsmap", _some_map()), _read_map
    ),
    "session": Format(_make_session, _read_session),
    "methods": Format(
        _copied(METHODS_FILE),
        lambda folder: load_methods([str(folder / "methods.yaml")]),
    ),
    "pose-target": Format(_make_pose_target, _packet(decode_pose_target)),
    "velocity-target": Format(
        _make_velocity_target, _packet(decode_velocity_target)
    ),
    "base-status": Format(_make_base_status, _packet(decode_base_status)),
}

FORMATS = SPLATS | CAPTURES | OTHERS


def interleaved(names: list[str], first: int):
    """Names and seeds of cases without end: each seed for every format."""
    for seed in itertools.count(first):
        for name in names:
            yield name, seed
