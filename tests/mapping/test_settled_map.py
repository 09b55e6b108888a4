"""A thing that comes to stay is handed from what moves to the live map."""

import dataclasses as dc
from pathlib import Path

import numpy as np
import pytest
from handover import who_knows
from mapped_table import CAMERA, make_job, table_world
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from remosplat_drake.app.world import World
from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.camera.rendered_camera import RenderedCamera
from remosplat_drake.detection.detection_camera_config import (
    DetectionCameraConfig,
)
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.known_scene import KnownScene, surface_points
from remosplat_drake.detection.settled_requests import SettledRequests
from remosplat_drake.detection.simulated.camera_detection import (
    CameraDetection,
    simulated_detection,
)
from remosplat_drake.mapping.live_map import LiveMap
from remosplat_drake.mapping.mapping_process import MappingProcess
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.scene.moving.mover_track import MoverConfig, WaypointConfig
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.station.mover_source import MoverSource

PERIOD, LATENCY = 0.02, 0.4
HALF = np.array([0.07, 0.07, 0.05])
PLACE = np.array([0.85, -0.19, 0.4])
ARRIVAL = 1.2
DETECTION = DetectionConfig(settle=0.6)
CAMERAS = [
    DetectionCameraConfig(
        name, translation=[-0.2, y, 1.7], look_at=[0.9, -0.1, 0.4], rate=15
    )
    for name, y in (("left", 1.6), ("right", -1.8))
]

PARCEL = MoverConfig(
    name="parcel",
    half_extents=HALF.tolist(),
    radius=0.001,
    waypoints=[
        WaypointConfig(0.0, (PLACE - [0, 1.2, 0]).tolist()),
        WaypointConfig(ARRIVAL, PLACE.tolist()),
    ],
)


def make_wrist_camera(world: World) -> RenderedCamera:
    """A camera that sees the parcel, too."""
    tracks = [PARCEL.make(Path())]
    return RenderedCamera(CAMERA, world.robot, world.truth, tracks=tracks)


class Room:
    """A robot before a table, two cameras, a live map, and what comes."""

    def __init__(self, process: MappingProcess):
        world, robot = table_world(), table_world().robot
        builder = DiagramBuilder()
        source = builder.AddSystem(ConstantVectorSource(world.q0))
        q = source.get_output_port()
        truth = builder.AddSystem(MoverSource(tracks=[PARCEL.make(Path())]))
        self.oracle = DistanceOracle.AddToBuilder(
            builder,
            robot=robot,
            field=world.field,
            max_distance=0.5,
            configuration=q,
        )
        known = KnownScene(
            world.field, DETECTION, surface_points(world.splat_W, None)
        )
        self.detection = CameraDetection.AddToBuilder(
            builder,
            detection=simulated_detection(
                CAMERAS, robot, world.truth, known, DETECTION, seed=0
            ),
            configuration=q,
            truth=truth.get_output_port(),
            distance_field=self.oracle.GetOutputPort("distance_field"),
            period=PERIOD,
        )
        mount = CameraMount(robot, CAMERA.hand_eye(), CAMERA.frame)
        settled = SettledRequests.AddToBuilder(
            builder,
            configuration=q,
            movers=self.detection.GetOutputPort("movers"),
            in_view=lambda q, p_W: CAMERA.sees(mount.pose(q), p_W),
            settle=DETECTION.settle,
        )
        self.map = LiveMap.AddToBuilder(
            builder,
            configuration=q,
            settled=settled.GetOutputPort("map_requests"),
            passing=settled.GetOutputPort("passing"),
            oracle=self.oracle,
            process=process,
            initial=SceneMap(0, None, (), -np.inf, world.field),
            n_q=robot.n_q,
            period=PERIOD,
            latency=LATENCY,
        )
        self.simulator = Simulator(builder.Build())
        self.root = self.simulator.get_mutable_context()
        self.ask(MapRequests())
        self.simulator.Initialize()

    def ask(self, requests: MapRequests) -> None:
        context = self.map.GetMyMutableContextFromRoot(self.root)
        self.map.GetInputPort("requests").FixValue(context, Value(requests))

    def advance(self) -> float:
        """To just after the next tick; returns the time."""
        time = self.root.get_time() + PERIOD
        self.simulator.AdvanceTo(time)
        return time

    def evaluated(self, system, port: str):
        context = system.GetMyContextFromRoot(self.root)
        return system.GetOutputPort(port).Eval(context)

    def who_knows(self) -> set[str]:
        """Which of map and movers contain the parcel at this time."""
        field = self.evaluated(self.oracle, "distance_field")
        movers = self.evaluated(self.detection, "movers")
        return who_knows(PLACE, HALF, field, movers)


@pytest.fixture(scope="module")
def room(rendering, tmp_path_factory):
    world = table_world()
    folder = tmp_path_factory.mktemp("settled") / "session"
    job = make_job(world, folder, make=make_wrist_camera)
    process = MappingProcess(dc.replace(job, base=world.splat_W))
    yield Room(process)
    process.close()


@pytest.mark.slow
def test_what_settles_is_in_the_map_before_it_leaves_the_movers(room):
    """The first frame is of the parcel: a single one adds to a splat."""
    story, time = [], 0.0
    while time < 6.0 and story[-1:] != [{"map"}]:
        time = room.advance()
        known = room.who_knows()
        if time > ARRIVAL + 0.2 and known not in story[-1:]:
            story.append(known)
    assert story == [{"movers"}, {"movers", "map"}, {"map"}]
    assert room.map.status(room.map.GetMyContextFromRoot(room.root)).swaps == 1
    assert not len(room.evaluated(room.detection, "movers"))
