"""The scene that all clients of the cockpit share."""

import numpy as np
import pytest

viser = pytest.importorskip("viser")

from cockpit_rig import Rig

from remosplat_drake.cockpit.messages import PageContent
from remosplat_drake.cockpit.robot_shapes import robot_shapes
from remosplat_drake.cockpit.scene import CockpitScene


@pytest.fixture
def server():
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


@pytest.fixture
def job(request):
    rig = Rig(request.param)
    yield rig.job
    rig.process.close()


@pytest.mark.parametrize("job", ["TwoPandasReach"], indirect=True)
def test_each_hand_has_its_target(server, job):
    robot = job.robot
    scene = CockpitScene(server, job, robot_shapes(robot))
    X_WTs = robot.end_effector_poses(robot.q_home)
    X_WTs[1, :3, 3] += 0.1
    content = PageContent(
        time=0.0,
        q=robot.q_home,
        X_WE=X_WTs[0],
        X_WB=np.eye(4),
        X_WT=X_WTs[0],
        X_WTs=X_WTs,
    )
    scene.show(content)
    drawn = [frame.position for frame in scene._targets]
    np.testing.assert_allclose(drawn, X_WTs[:, :3, 3])


@pytest.mark.slow
@pytest.mark.parametrize("job", ["TableTeleop"], indirect=True)
def test_an_only_hand_has_one(server, job):
    robot = job.robot
    scene = CockpitScene(server, job, robot_shapes(robot))
    X_WT = robot.end_effector_pose(robot.q_home)
    scene.show(
        PageContent(0.0, robot.q_home, X_WE=X_WT, X_WB=np.eye(4), X_WT=X_WT)
    )
    (frame,) = scene._targets
    np.testing.assert_allclose(frame.position, X_WT[:3, 3])
