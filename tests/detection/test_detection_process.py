"""`remosplat detect` as a process, between cameras and a listener."""

import time

import pytest
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from robot_process import running
from wire_messages import arm_message, base_message

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.base.clock import wall_utime
from remosplat_drake.commands.main import main
from remosplat_drake.detection.simulated.wire_camera import WireCamera
from remosplat_drake.hardware.hardware_config import beside
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.movers import decode_movers
from remosplat_drake.scene.moving.track import movers_at

SCENE = "package://remosplat_drake/models/scenes/table/scene.json"
SCENARIO = f"""
Seen:
  scene: {{truth: {SCENE}}}
  oracle: !GroundTruth {{}}
  cameras:
  - name: left
    translation: [-0.2, 1.6, 1.7]
    look_at: [1.0, 0.2, 0.7]
    width: 160
    height: 120
  - name: right
    translation: [0.2, -1.6, 1.7]
    look_at: [1.0, 0.2, 0.7]
    width: 160
    height: 120
  movers:
  - name: ball
    radius: 0.15
    waypoints: [{{translation: [0.6, 0.5, 1.3]}}]
"""


@pytest.fixture
def spec(tmp_path):
    path = tmp_path / "seen.yaml"
    path.write_text(SCENARIO)
    return str(path)


def test_a_process_tells_what_cameras_see_and_which_is_silent(spec):
    scenario, url = load_scenario(spec), free_url()
    world = load_world(scenario)
    tracks = [config.make(scenario.folder) for config in scenario.movers]
    lcm, camera_lcm = DrakeLcm(url), DrakeLcm(beside(url))
    cameras = [
        WireCamera(c, world.robot, world.truth, tracks, camera_lcm)
        for c in scenario.cameras
    ]
    inbox = Inbox(lcm, [channels.MOVERS])
    told = []

    def until(done, cameras):
        end = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < end
            assert process.poll() is None, process.communicate()
            now, q = wall_utime(), world.q0.tolist()
            arm = arm_message(utime=now, joint_position=q[3:])
            lcm.Publish(channels.PANDA_STATUS, arm)
            base = base_message(utime=now, pose=q[:3])
            lcm.Publish(channels.BASE_STATUS, base)
            for camera in cameras:
                camera.take(world.q0, now, 0.0)
            for _, data in inbox.fetch(0.02):
                told.append(decode_movers(data))

    with running("detect", spec, "--lcm-url", url) as process:
        until(lambda: told and len(told[-1]), cameras)
        (ball,) = movers_at(tracks, 0.0)
        apart = ball.X_WM.translation() - told[-1].movers[0].X_WM.translation()
        assert abs(apart).max() < 0.4
        assert {c.name for c in told[-1].cameras} == {"left", "right"}
        until(lambda: right(told).problem.startswith("no image"), cameras[:1])
        assert right(told).seen < told[-1].stamp


def right(told):
    return next(c for c in told[-1].cameras if c.name == "right")


def test_without_cameras_there_is_nothing_to_look_at(capsys):
    assert main(["detect", "TableReach"]) == 2
    assert "cameras: is empty" in capsys.readouterr().err


def test_a_camera_that_does_not_exist_is_refused(capsys):
    assert main(["camera-sim", "PersonSeen", "--camera", "lefd"]) == 2
    assert "did you mean 'left'?" in capsys.readouterr().err
