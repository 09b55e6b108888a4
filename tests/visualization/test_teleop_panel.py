"""Sliders, buttons and gamepad: by message, and in a real browser."""

import time
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
from browser import find_chromium, open_browser
from page_messages import click, move_gamepad, slide
from patience import PATIENCE
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.target_state import FOLLOW, GO, TargetState
from remosplat_drake.teleop.gamepad import SILENCE
from remosplat_drake.teleop.operator_target import OperatorTarget
from remosplat_drake.teleop.target_motion import MotionLaw
from remosplat_drake.teleop.teleop_config import SavedPose, TeleopConfig
from remosplat_drake.visualization import dead_man
from remosplat_drake.visualization import teleop_panel as tp
from remosplat_drake.visualization.dead_man import pulse
from remosplat_drake.visualization.page_style import button
from remosplat_drake.visualization.teleop_panel import TeleopPanel

CONFIG = TeleopConfig(
    workspace_lower=[-1.0, -1.0, 0.0],
    workspace_upper=[1.0, 1.0, 2.0],
    poses={"shelf": SavedPose([0.5, 0, 1]), "bin": SavedPose([0.5, 0.2, 1])},
)
X_WH = RigidTransform(
    RotationMatrix.MakeXRotation(np.pi), [0.5, 0.1, 0.6]
).GetAsMatrix4()
HELD = [0.0] * 5 + [1.0]
SLIDERS = ["x [m]", "y [m]", "z [m]", "roll", "pitch", "yaw"]


class Rig:
    """A panel with a target that the test moves."""

    def __init__(self, page, **arguments):
        self.page = page
        self.panel = TeleopPanel(
            page=page, config=CONFIG, X_WH=X_WH, **arguments
        )
        self.context = self.panel.CreateDefaultContext()
        self.show(TargetState.at_rest(X_WH, "hold: start"))

    def slider(self, title: str) -> str:
        names = self.page.meshcat.GetSliderNames()
        return next(name for name in names if f">{title}" in name)

    def values(self) -> list[float]:
        value = self.page.meshcat.GetSliderValue
        return [value(self.slider(title)) for title in SLIDERS]

    def move(self, title: str, value: float):
        slide(self.page.meshcat, self.slider(title), value)

    def show(self, state: TargetState, time: float = 0.0):
        """What the target does at a time."""
        self.context.SetTime(time)
        self.panel.GetInputPort("state").FixValue(self.context, Value(state))
        self.panel.ForcedPublish(self.context)

    def _output(self, name: str):
        self.context.SetTime(self.context.get_time() + 0.01)
        return self.panel.GetOutputPort(name).Eval(self.context)

    @property
    def command(self):
        return self._output("command")

    @property
    def requests(self):
        return self._output("map_requests")


@pytest.fixture
def rig(page) -> Rig:
    return Rig(page)


def pose(p_WT, rpy_deg=(0.0, 0.0, 0.0)) -> np.ndarray:
    """A pose that is turned away from where the robot began."""
    turn = RollPitchYaw(np.radians(rpy_deg)).ToRotationMatrix().matrix()
    X_WT = X_WH.copy()
    X_WT[:3, :3] = turn @ X_WH[:3, :3]
    X_WT[:3, 3] = p_WT
    return X_WT


def test_untouched_controls_ask_for_nothing(rig):
    assert rig.values() == [0.5, 0.1, 0.6, 0.0, 0.0, 0.0]
    command, requests = rig.command, rig.requests
    assert command.X_WT is None and command.V_W is None
    assert command.moves == command.holds == command.homes == 0
    assert command.poses == command.scans == 0
    assert requests.frames == requests.refines == requests.undos == 0
    assert requests.saves == 0 and requests.scene is None
    assert rig.page.status["target"] == "hold: start"


def test_a_robot_with_a_hand_has_buttons_for_it(page):
    rig = Rig(page, has_hand=True)
    click(page.meshcat, tp.CLOSE)
    click(page.meshcat, tp.CLOSE)
    click(page.meshcat, tp.OPEN)
    assert (rig.command.opens, rig.command.closes) == (1, 2)


def test_sliders_are_a_pose_about_the_axes_of_the_world(rig):
    rig.move("z [m]", 0.8)
    command = rig.command
    assert command.moves == 1 and command.source == "sliders"
    np.testing.assert_allclose(command.X_WT, pose([0.5, 0.1, 0.8]), atol=1e-12)
    rig.move("yaw", 90.0)
    command = rig.command
    assert command.moves == 2
    expected = pose([0.5, 0.1, 0.8], [0, 0, 90])
    np.testing.assert_allclose(command.X_WT, expected, atol=1e-12)
    assert rig.command.moves == 2


def test_sliders_follow_the_target_and_that_is_no_wish(rig):
    there = pose([0.2, -0.3, 1.0], [10, -20, 30])
    rig.show(TargetState(GO, there, np.zeros(6), there), time=1.0)
    np.testing.assert_allclose(
        rig.values(), [0.2, -0.3, 1.0, 10, -20, 30], atol=1e-9
    )
    assert rig.command.moves == 0
    # Taken hold of, they keep the rest of the pose.
    rig.move("x [m]", 0.4)
    expected = pose([0.4, -0.3, 1.0], [10, -20, 30])
    np.testing.assert_allclose(rig.command.X_WT, expected, atol=1e-9)


def test_sliders_in_hand_stay_where_they_are(rig):
    """Before the target has heard of them, and while it follows them."""
    rig.move("x [m]", 0.9)
    start = TargetState.at_rest(X_WH)
    rig.show(start, time=1.0)
    rig.show(start, time=1.2)
    assert rig.values()[0] == 0.9
    following = TargetState(FOLLOW, X_WH, np.zeros(6), X_WH)
    rig.show(following, time=5.0)
    assert rig.values()[0] == 0.9 and rig.command.moves == 1
    rig.show(start, time=6.0)
    assert rig.values()[0] == 0.5 and rig.command.moves == 1


def test_buttons_of_the_target_are_counted(rig):
    meshcat = rig.page.meshcat
    for name in (tp.HOLD, tp.HOME, tp.HOME, tp.SCAN):
        click(meshcat, name)
    command = rig.command
    assert (command.holds, command.homes, command.scans) == (1, 2, 1)
    click(meshcat, button("→ bin"))
    command = rig.command
    assert (command.pose, command.poses) == ("bin", 1)
    click(meshcat, button("→ shelf"))
    command = rig.command
    assert (command.pose, command.poses) == ("shelf", 2)


def test_buttons_of_the_map_are_counted(page):
    scenes = PrimitiveScene(), PrimitiveScene()
    rig = Rig(page, scenes=scenes)
    for name in (tp.ADD_FRAME, tp.ADD_FRAME, tp.REFINE, tp.UNDO, tp.SAVE):
        click(page.meshcat, name)
    requests = rig.requests
    assert (requests.frames, requests.refines) == (2, 1)
    assert (requests.undos, requests.saves) == (1, 1)
    for expected in (scenes[1], scenes[0], scenes[1]):
        click(page.meshcat, tp.CHANGE_SCENE)
        assert rig.requests.scene is expected


def test_there_are_no_buttons_for_what_is_not_there(page):
    rig = Rig(page, mapping=False)
    names = page.meshcat.GetButtonNames()
    assert tp.HOLD in names
    assert not {tp.SCAN, tp.UNDO, tp.CHANGE_SCENE} & set(names)
    assert rig.command.scans == rig.requests.undos == 0


@pytest.fixture
def clock(monkeypatch) -> SimpleNamespace:
    """The page's clock, which stands still."""
    clock = SimpleNamespace(now=100.0)
    clock.monotonic = lambda: clock.now
    monkeypatch.setattr(dead_man, "time", clock)
    return clock


def test_a_gamepad_needs_its_dead_man_button(rig, clock):
    meshcat = rig.page.meshcat
    move_gamepad(meshcat, [0.0, -1.0, 0.0, 0.0], [0.0] * 6)
    click(meshcat, pulse(CONFIG.gamepad.dead_man))
    assert rig.command.V_W is None
    move_gamepad(meshcat, [0.0, -1.0, 0.0, 0.0], HELD)
    click(meshcat, pulse(CONFIG.gamepad.dead_man))
    command = rig.command
    assert command.source == "gamepad"
    speed = CONFIG.gamepad.speed
    np.testing.assert_allclose(command.V_W, [0, 0, 0, speed, 0, 0])


def test_a_page_that_is_silent_holds_no_button(rig, clock):
    """The last message said that it is held; then the page hung."""
    meshcat = rig.page.meshcat
    move_gamepad(meshcat, [0.0, -1.0, 0.0, 0.0], HELD)
    assert rig.command.V_W is None
    click(meshcat, pulse(CONFIG.gamepad.dead_man))
    assert rig.command.V_W is not None
    clock.now += 0.9 * SILENCE
    assert rig.command.V_W is not None
    clock.now += 0.2 * SILENCE
    assert rig.command.V_W is None


PAD = """
window.pad = {index: 0, connected: true, axes: [0, -1, 0, 0],
  buttons: Array.from({length: 17}, () => ({value: 0}))};
navigator.getGamepads = () => [window.pad];
"""


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_a_browser_moves_the_target(page, frankie):
    """By slider, key, button and gamepad, and not without its button."""
    q0 = np.zeros(frankie.n_q)
    X_WE = frankie.end_effector_pose(q0)
    builder = DiagramBuilder()
    panel = TeleopPanel.AddToBuilder(
        builder, page=page, config=CONFIG, X_WH=X_WE
    )
    configuration = builder.AddSystem(ConstantVectorSource(q0))
    target = OperatorTarget.AddToBuilder(
        builder,
        configuration=configuration.get_output_port(),
        command=panel.GetOutputPort("command"),
        robot=frankie,
        q0=q0,
        law=MotionLaw(CONFIG, X_WE, 0.02),
    )
    builder.Connect(target.GetOutputPort("state"), panel.GetInputPort("state"))
    simulator = Simulator(builder.Build())
    context = target.GetMyContextFromRoot(simulator.get_context())

    def state() -> TargetState:
        return target.state(context)

    def wait_for(condition: Callable[[], bool]):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            simulator.AdvanceTo(simulator.get_context().get_time() + 0.02)
            if condition():
                return
            time.sleep(0.005)
        raise AssertionError(state().text)

    def wait(seconds: float):
        end = time.monotonic() + seconds
        wait_for(lambda: time.monotonic() > end)

    with open_browser((1200, 900)) as tab:
        tab.run_first(PAD)
        tab.open(page.url)
        tab.wait_for("document.querySelectorAll('.remosplat-slider').length")
        wait_for(lambda: len(page.meshcat.GetGamepad().axes) == 4)
        wait(0.5)
        assert state().mode == "hold"

        tab.click(".cr:has(.remosplat-slider) .slider", at=0.75)
        wait_for(lambda: state().mode == FOLLOW)
        wait_for(lambda: abs(state().X_WT[0, 3] - 0.5) < 0.03)

        z = state().X_WT[2, 3]
        tab.press("KeyR")
        wait_for(lambda: abs(state().X_WT[2, 3] - z - 0.005) < 0.003)

        tab.click(".cr:has(.remosplat-button)")
        wait_for(lambda: state().text == "hold")

        tab.evaluate("window.pad.buttons[5] = {value: 1}")
        wait_for(lambda: state().X_WT[0, 3] > X_WE[0, 3] + 0.02)
        assert state().text == "led by the gamepad"
        tab.evaluate("window.pad.buttons[5] = {value: 0}")
        wait_for(lambda: state().mode == "hold")

        tab.evaluate("window.pad.buttons[5] = {value: 1}")
        wait_for(lambda: state().mode == "velocity")
        tab.open("about:blank")
        wait_for(lambda: state().mode == "hold")
