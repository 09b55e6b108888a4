"""A pose sent through a real wire within the process."""

import numpy as np
from pydrake.lcm import DrakeLcm
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from remosplat_drake.hardware.wire.messages.pose_target import pose_target
from remosplat_drake.hardware.wire.messages.velocity_target import (
    velocity_target,
)
from remosplat_drake.hardware.wire.packets import to_utime
from remosplat_drake.signals.target_state import FOLLOW, HOLD, VELOCITY
from remosplat_drake.teleop.lcm_operator import LcmOperator
from remosplat_drake.teleop.motion_law import MotionLaw
from remosplat_drake.teleop.operator_target import OperatorTarget
from remosplat_drake.teleop.teleop_config import PoseStreamConfig, TeleopConfig


def encoded(time: float, x: float) -> bytes:
    message = pose_target()
    message.utime = to_utime(time)
    message.position = [x, 0.0, 0.0]
    message.quaternion = [1.0, 0.0, 0.0, 0.0]
    return message.encode()


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
        self.lcm.Publish("T", encoded(self.now, x))

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


DT, Q = 0.01, (0.3, 0.5, 0.0)
"""Period [s], and the configuration of the arm [rad]."""


class LedArm:
    """An arm that stands still, whose target a stream on a wire leads.

    Attributes:
        lcm: The wire.
        now: The time that the stream sees [s].
        state: The target's state.
    """

    def __init__(self, robot, **config):
        self.lcm, self.q, self.now = DrakeLcm("memq://"), np.array(Q), 1000.0
        builder = DiagramBuilder()
        arm = builder.AddSystem(ConstantVectorSource(self.q))
        stream = builder.AddSystem(
            LcmOperator(
                config=PoseStreamConfig(expiry=0.3, **config),
                period=DT,
                lcm=self.lcm,
                clock=lambda: self.now,
            )
        )
        self._target = OperatorTarget.AddToBuilder(
            builder,
            configuration=arm.get_output_port(),
            command=stream.GetOutputPort("command"),
            robot=robot,
            q0=self.q,
            law=MotionLaw.make(TeleopConfig(), robot, self.q, DT),
        )
        self._simulator, self._ticks = Simulator(builder.Build()), 0
        self._context = self._target.GetMyContextFromRoot(
            self._simulator.get_context()
        )

    @property
    def state(self):
        return self._target.state(self._context)

    def tick(self, channel: str, message: bytes | None) -> None:
        """Sends a message, if any, and simulates a period."""
        self.now += DT
        if message is not None:
            self.lcm.Publish(channel, message)
        self._ticks += 1
        self._simulator.AdvanceTo(DT * self._ticks)


def test_a_robot_that_followed_a_silent_stream_holds(three_link):
    arm, modes = LedArm(three_link, channel="T"), []
    for i in range(80):
        arm.tick("T", encoded(arm.now + DT, 0.1) if i < 20 else None)
        modes.append(arm.state.mode)
    # The last pose came after 0.2 s; two ticks pass it on.
    assert modes[10] == modes[45] == FOLLOW
    assert modes[55] == modes[-1] == HOLD
    text = "hold: the pose stream has been silent for 0.3 s"
    assert arm.state.text == text
    np.testing.assert_allclose(
        arm.state.X_WT, three_link.end_effector_pose(arm.q)
    )


def test_a_target_moves_by_velocities_and_holds_in_their_silence(three_link):
    arm = LedArm(three_link, velocity_channel="V")
    start = arm.state.X_WT
    for i in range(100):
        message = velocity_target()
        message.utime = to_utime(arm.now + DT)
        message.linear = [0.0, 0.0, 0.1]
        arm.tick("V", message.encode() if i < 50 else None)
        if i == 49:
            led = arm.state
    assert led.mode == VELOCITY
    assert led.text == "led by the velocity stream"
    np.testing.assert_allclose(led.V_WT, [0, 0, 0, 0, 0, 0.1])
    # It gains speed within 0.2 s, and two ticks pass a message on.
    way = led.X_WT[:3, 3] - start[:3, 3]
    np.testing.assert_allclose(way, [0, 0, 0.1 * (0.48 - 0.1)], atol=2e-3)
    held = arm.state
    assert held.mode == HOLD
    text = "hold: the velocity stream has been silent for 0.3 s"
    assert held.text == text
