"""Movers in a dynamic station push the robot that they meet."""

from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from remosplat_drake.scene.moving.door import DoorAngle, SwingingDoor
from remosplat_drake.scene.moving.mover_track import (
    MoverConfig,
    WaypointConfig,
)
from remosplat_drake.scene.moving.track import Track, movers_at
from remosplat_drake.station.mover_source import MoverSource
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_config import DynamicStation

Q0 = np.array([0.0, 0.0, 0.0])


def ball(*way: list[float]) -> Track:
    return MoverConfig(
        name="ball",
        radius=0.1,
        waypoints=[WaypointConfig(0.5 * i, p) for i, p in enumerate(way)],
    ).make(Path())


class Moved:
    """A dynamic station of an arm that is commanded to stand."""

    def __init__(self, robot, *tracks: Track):
        builder = DiagramBuilder()
        self.station = builder.AddSystem(
            MakeSimulatedStation(
                config=DynamicStation(),
                robot=robot,
                scene=None,
                q0=Q0,
                movers=list(movers_at(tracks, 0.0)),
            )
        )
        source = builder.AddSystem(MoverSource(tracks=tracks))
        builder.Connect(
            source.get_output_port(), self.station.GetInputPort("movers")
        )
        still = builder.AddSystem(ConstantVectorSource(np.zeros(robot.n_u)))
        name = robot.description.arm.name
        builder.Connect(
            still.get_output_port(),
            self.station.GetInputPort(f"{name}.velocity_commanded"),
        )
        self.q_name = f"{name}.position_measured"
        self.simulator = Simulator(builder.Build())

    def advance(self, time: float):
        self.simulator.AdvanceTo(time)
        context = self.station.GetMyContextFromRoot(
            self.simulator.get_context()
        )
        return (
            np.array(self.station.GetOutputPort(self.q_name).Eval(context)),
            self.station.GetOutputPort("cheat.contact").Eval(context),
            context,
        )


def hand(robot) -> np.ndarray:
    return robot.spheres_at(Q0).p_WS[-2]


def test_a_robot_at_rest_feels_what_is_pushed_into_it(three_link):
    above = hand(three_link) + np.array([0.0, 0.0, 0.35])
    through = hand(three_link) - [0.0, 0.0, 0.15]
    dut = Moved(three_link, ball(list(above), list(through)))
    q, contact, _ = dut.advance(0.05)
    assert contact.movers == ()
    np.testing.assert_allclose(q, Q0, atol=1e-6)
    felt = set()
    for time in np.arange(0.1, 0.55, 0.05):
        q, contact, _ = dut.advance(time)
        felt |= set(contact.movers)
    assert felt and {name for _, name in felt} == {"ball"}
    assert np.abs(q - Q0).max() > 0.01


def test_what_passes_beside_is_not_felt(three_link):
    side = hand(three_link) + np.array([0.0, 0.5, 0.3])
    dut = Moved(three_link, ball(list(side), list(side - [0, 0, 0.6])))
    q, contact, _ = dut.advance(0.55)
    assert contact.movers == ()
    np.testing.assert_allclose(q, Q0, atol=1e-6)


def test_bodies_are_where_their_movers_are(three_link):
    door = SwingingDoor(
        hinge=[2.0, 2.0, 0.0],
        angles=[DoorAngle(0.0, 0.0), DoorAngle(1.0, 90.0)],
    ).make(Path())
    dut = Moved(three_link, door, ball([3, 3, 1], [3, 4, 1]))
    for time in (0.2, 0.5, 0.9):
        dut.advance(time)
        plant = dut.station.GetSubsystemByName("plant")
        inside = plant.GetMyContextFromRoot(dut.simulator.get_context())
        for i, mover in enumerate(
            movers_at([door, ball([3, 3, 1], [3, 4, 1])], time)
        ):
            body = plant.GetBodyByName(f"{i}: {mover.name}")
            X_WB = body.EvalPoseInWorld(inside)
            off = mover.X_WM.inverse() @ X_WB
            assert np.linalg.norm(off.translation()) < 0.005
            assert off.IsNearlyEqualTo(RigidTransform(), 0.01)


def test_movers_pass_through_what_stands_and_each_other(three_link):
    low = ball([2.0, 0.0, -0.05], [2.5, 0.0, -0.05])
    other = ball([2.0, 0.05, 0.0], [2.5, 0.0, 0.0])
    dut = Moved(three_link, low, other)
    _, contact, _ = dut.advance(0.4)
    assert contact.movers == contact.scene == contact.robot == ()


def test_a_station_without_movers_has_no_such_port(three_link):
    station = MakeSimulatedStation(
        config=DynamicStation(), robot=three_link, scene=None, q0=Q0
    )
    assert not station.HasInputPort("movers")
