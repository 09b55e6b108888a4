"""An operator's script closes and opens the hand of a simulated robot."""

import pytest
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.teleop_session import open_teleoperation
from remosplat_drake.app.world import load_world
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.station_config import kinematic_simulator_config

SCRIPT = """
steps:
- {time: 0.1, press: close}
- {time: 1.0, press: open}
"""


def test_a_script_closes_and_opens_the_hand(tmp_path):
    script = tmp_path / "script.yaml"
    script.write_text(SCRIPT)
    scenario = load_scenario(
        "TableTeleop",
        f"{{mapping: {{enabled: false}}, teleop: {{trajectory: {script}}}}}",
    )
    world = load_world(scenario)
    session = open_teleoperation(
        scenario, world, tmp_path / "session", hardware=False
    )
    application = build(scenario, world, teleoperation=session)
    simulator = Simulator(application.diagram)
    ApplySimulatorConfig(
        kinematic_simulator_config(scenario.control_period), simulator
    )
    station = application.station
    hand = world.robot.description.hand
    assert hand is not None
    name = ports.hand_state(hand)
    port = station.GetOutputPort(name)
    context = station.GetMyContextFromRoot(simulator.get_context())
    open_width = port.Eval(context)[0]
    assert open_width == pytest.approx(0.08)
    simulator.AdvanceTo(0.95)
    assert port.Eval(context)[0] < 0.002
    simulator.AdvanceTo(2.0)
    assert port.Eval(context)[0] == pytest.approx(open_width, abs=1e-3)
    session.close()
