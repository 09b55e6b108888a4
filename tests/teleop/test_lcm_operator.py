"""A pose sent through a real wire within the process."""

import numpy as np
from pydrake.lcm import DrakeLcm
from pydrake.systems.analysis import Simulator

from remosplat_drake.messages.packets import to_utime
from remosplat_drake.messages.pose_target import pose_target
from remosplat_drake.teleop.config import PoseStreamConfig
from remosplat_drake.teleop.lcm_operator import LcmOperator


class Wire:
    """A sender, a listener and their common clock."""

    def __init__(self):
        self.lcm = DrakeLcm("memq://")
        self.now = 1000.0
        self.system = LcmOperator(
            config=PoseStreamConfig(channel="T", expiry=0.3),
            period=0.01,
            lcm=self.lcm,
            clock=lambda: self.now,
        )
        self.simulator = Simulator(self.system)
        self.simulator.Initialize()

    def send(self, x: float):
        message = pose_target()
        message.utime = to_utime(self.now)
        message.position = [x, 0.0, 0.0]
        message.quaternion = [1.0, 0.0, 0.0, 0.0]
        self.lcm.Publish("T", message.encode())

    def wait(self, duration: float):
        context = self.simulator.get_context()
        self.now += duration
        self.simulator.AdvanceTo(context.get_time() + 0.02)
        return self.system.GetOutputPort("command").Eval(context)


def test_poses_are_followed_and_silence_is_told():
    wire = Wire()
    assert wire.wait(0.1).moves == 0
    wire.send(0.5)
    command = wire.wait(0.1)
    assert (command.moves, command.trouble) == (1, "")
    np.testing.assert_allclose(command.X_WT[:3, 3], [0.5, 0, 0])
    wire.send(0.6)
    command = wire.wait(0.1)
    assert command.moves == 1
    np.testing.assert_allclose(command.X_WT[:3, 3], [0.6, 0, 0])
    assert "silent" in wire.wait(0.4).trouble


def test_a_url_opens_a_wire_of_its_own():
    config = PoseStreamConfig(lcm_url="memq://")
    system = LcmOperator(config=config, period=0.01)
    context = system.CreateDefaultContext()
    assert system.GetOutputPort("command").Eval(context).moves == 0
