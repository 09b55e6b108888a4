"""Robots, stations and a harness that drives them."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Diagram

from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.station.station_config import kinematic_simulator_config

THREE_LINK = Path(__file__).resolve().parents[1] / "data" / "three_link.yaml"


@pytest.fixture(scope="session")
def frankie() -> RobotModel:
    return load_robot("frankie")


@pytest.fixture(scope="session")
def three_link() -> RobotModel:
    return load_robot(THREE_LINK)


class Harness:
    """A station in a simulator, commanded through its ports."""

    def __init__(
        self,
        station: Diagram,
        robot: RobotModel,
        control_period: float = 0.02,
        hand: tuple[float, float] | None = None,
    ):
        self.station = station
        self.robot = robot
        self.simulator = Simulator(station)
        ApplySimulatorConfig(
            kinematic_simulator_config(control_period), self.simulator
        )
        self.context = self.simulator.get_mutable_context()
        self.command(np.zeros(robot.n_u))
        if hand is not None:
            self.fix("hand.command", hand)

    def fix(self, port: str, value) -> None:
        self.station.GetInputPort(port).FixValue(
            self.context, np.asarray(value, float)
        )

    def command(self, u: np.ndarray) -> None:
        """Holds u from now on."""
        n_base = self.robot.n_base
        if n_base:
            self.fix("base.velocity_commanded", u[:n_base])
        name = self.robot.description.arm.name
        self.fix(f"{name}.velocity_commanded", u[n_base:])

    def advance(self, duration: float) -> None:
        self.simulator.AdvanceTo(self.context.get_time() + duration)

    def eval(self, port: str):
        return self.station.GetOutputPort(port).Eval(self.context)

    @property
    def q(self) -> np.ndarray:
        """The measured configuration."""
        name = self.robot.description.arm.name
        arm = self.eval(f"{name}.position_measured")
        if not self.robot.n_base:
            return arm
        return np.concatenate([self.eval("base.pose_measured"), arm])

    @property
    def u(self) -> np.ndarray:
        """The measured velocities."""
        name = self.robot.description.arm.name
        arm = self.eval(f"{name}.velocity_measured")
        if not self.robot.n_base:
            return arm
        return np.concatenate([self.eval("base.velocity_measured"), arm])


@pytest.fixture
def harness() -> type[Harness]:
    return Harness
