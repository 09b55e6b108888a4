"""The process that looks for new things uses the control loop's map."""

import time
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE
from pydrake.common.value import Value
from pydrake.lcm import DrakeLcm
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource
from room import CONFIG, known_room

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.detection.detection_camera_config import (
    DetectionCameraConfig,
)
from remosplat_drake.detection.followed_map import FollowedMap
from remosplat_drake.detection.kernels.scan import UNASKED
from remosplat_drake.detection.map_announcer import MapAnnouncer
from remosplat_drake.detection.wire_detection import WireDetection
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.channels import COUNTING_MAP
from remosplat_drake.hardware.wire.counting import (
    EXPIRY,
    CountingMap,
    decode_counting,
    encode_counting,
)
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.mapping.store.map_file import write_map
from remosplat_drake.mapping.store.session import Session, Version
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.splat.gaussian_splat import GaussianSplat

NEWCOMER = np.array([0.3, 0.0, 0.9])


def a_map(version: int) -> SceneMap:
    """As many balls in a row as the version has had changes."""
    splat = GaussianSplat(
        p_GK=NEWCOMER + np.arange(version)[:, None] * [0.0, 0.3, 0.0],
        quaternions=np.tile([1.0, 0, 0, 0], (version, 1)),
        scales=np.full((version, 3), 0.05),
        opacities=np.full(version, 0.9),
        colors=np.full((version, 3), 0.5),
    )
    field = SphereToEllipsoidField(splat)
    return SceneMap(version, version - 1, (), 1.0, field, splat)


@pytest.fixture
def session(tmp_path) -> Session:
    """A session with two maps."""
    session = Session.create(tmp_path / "session", "robot: {model: frankie}\n")
    for number in (1, 2):
        path = session.map_path(number)
        write_map(path, a_map(number))
        file = str(path.relative_to(session.folder))
        session.record(Version(number, number - 1, file, (), 1.0), set())
    return session


class Loop:
    """Messages of a control loop, and the process that follows them."""

    def __init__(self, folder: Path):
        self.own = known_room()
        self.followed = FollowedMap(folder, self.own, CONFIG)
        self.now = time.time()

    def say(self, version: int, revision: str = "") -> None:
        revision = revision or (
            a_map(version).field.revision if version else self.own.revision
        )
        said = CountingMap(version, revision)
        self.followed.hear(encode_counting(said, self.now), self.now)

    def until(self, done) -> None:
        end = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < end, self.followed.trouble
            self.followed.at(self.now)
            time.sleep(0.001)

    @property
    def shows_newcomer(self) -> bool:
        known = self.followed.at(self.now)
        return bool(known.distances(NEWCOMER[None])[0] <= 0.02)


def test_a_version_counts_once_it_is_named_and_read(session):
    loop = Loop(session.folder)
    assert loop.followed.at(loop.now) is loop.own
    loop.own.distances(np.array([[0.5, 0.1, 0.9], [0.1, 0.1, 0.2]]))
    loop.say(1)
    assert loop.followed.at(loop.now) is loop.own, "not read yet"
    loop.until(lambda: loop.followed.version == 1)
    assert loop.shows_newcomer
    asked = loop.own.nodes != UNASKED
    assert asked.sum() == 2
    assert (loop.followed.known.nodes[asked] != UNASKED).all(), "prepared"
    loop.say(2)
    assert loop.followed.at(loop.now).revision != loop.own.revision
    loop.until(lambda: loop.followed.version == 2)
    assert not loop.followed.trouble


def test_who_goes_back_shows_less_at_once(session):
    loop = Loop(session.folder)
    loop.say(2)
    loop.until(lambda: loop.followed.version == 2)
    loop.say(1)
    assert loop.followed.at(loop.now) is loop.own
    loop.until(lambda: loop.followed.version == 1)
    loop.say(0)
    assert loop.followed.at(loop.now) is loop.own
    assert not loop.followed.trouble


def test_silence_shows_less(session):
    loop = Loop(session.folder)
    loop.say(1)
    loop.until(lambda: loop.shows_newcomer)
    loop.now += 1.1 * EXPIRY
    assert loop.followed.at(loop.now) is loop.own
    loop.say(1)
    loop.until(lambda: loop.shows_newcomer)


def test_another_map_of_that_number_does_not_count(session):
    loop = Loop(session.folder)
    loop.say(1, "another")
    loop.until(lambda: loop.followed.trouble)
    assert "differs from the control loop's map" in loop.followed.trouble
    assert loop.followed.at(loop.now) is loop.own
    loop.say(0, "another")
    loop.followed.at(loop.now)
    assert loop.followed.trouble == "the control loop started with another map"
    loop.say(1)
    loop.until(lambda: loop.followed.version == 1)
    assert not loop.followed.trouble


def test_a_map_that_cannot_be_read_is_named(session):
    session.map_path(1).write_bytes(b"garbage")
    loop = Loop(session.folder)
    loop.say(1)
    loop.until(lambda: loop.followed.trouble)
    assert "map_0001.rsmap" in loop.followed.trouble
    loop.say(2)
    loop.until(lambda: loop.followed.version == 2)


def test_nonsense_and_folders_without_a_session_are_refused(tmp_path, session):
    with pytest.raises(RemoSplatError, match=r"session\.json"):
        FollowedMap(tmp_path, known_room(), CONFIG)
    followed = FollowedMap(session.folder, known_room(), CONFIG)
    with pytest.raises(BrokenMessage):
        followed.hear(b"nonsense", 0.0)


def test_a_control_loop_says_which_map_counts():
    lcm, now = DrakeLcm("memq://"), 1_700_000_000.0
    inbox = Inbox(lcm, ["MAP"])
    builder = DiagramBuilder()
    status = builder.AddSystem(
        ConstantValueSource(Value[object](MapStatus(a_map(2))))
    )
    MapAnnouncer.AddToBuilder(
        builder,
        map_status=status.get_output_port(),
        lcm=lcm,
        channel="MAP",
        clock=lambda: now,
    )
    Simulator(builder.Build()).AdvanceTo(1.0)
    said = [decode_counting(data, now) for _, data in inbox.fetch()]
    assert said == 6 * [CountingMap(2, a_map(2).field.revision)]


def test_what_looks_beside_a_loop_hears_it_on_the_wire(session):
    hardware = HardwareConfig(lcm_url=free_url())
    lcm, own = DrakeLcm(hardware.url), known_room()
    followed = FollowedMap(session.folder, own, CONFIG)
    camera = DetectionCameraConfig(translation=[0, 0, 2.0], look_at=[1, 0, 0])
    robot = load_robot("frankie")
    detection = WireDetection([camera], robot, own, CONFIG, hardware, followed)
    assert detection.map_in_use == "the scenario's map"
    said = CountingMap(1, a_map(1).field.revision)
    end = time.monotonic() + PATIENCE
    while detection.map_in_use != "map 1 of the session":
        assert time.monotonic() < end, detection.map_in_use
        # One message of a channel waits at a time; others are dropped.
        for data in (b"nonsense", encode_counting(said, time.time())):
            lcm.Publish(COUNTING_MAP, data)
            detection.step(0.005)
