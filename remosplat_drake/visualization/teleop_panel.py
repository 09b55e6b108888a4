"""`TeleopPanel`: the page's sliders, buttons and gamepad for an operator."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
)

from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.map_requests import MapRequests, scene_in_turn
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.target_state import FOLLOW, TargetState
from remosplat_drake.teleop.gamepad import gamepad_velocity
from remosplat_drake.teleop.teleop_config import TeleopConfig
from remosplat_drake.visualization.dead_man import DeadMan
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_style import button, heading, hidden
from remosplat_drake.visualization.pose_sliders import PoseSliders
from remosplat_drake.visualization.robot_view import PUBLISH_PERIOD

HOLD = button("Hold", "H")
HOME = button("Go home")
SCAN = button("Scan")
OPEN = button("Open hand", "O")
CLOSE = button("Close hand", "C")
ADD_FRAME = button("Add a frame", "M")
REFINE = button("Refine")
UNDO = button("Undo")
SAVE = button("Save splat")
GIVE_UP = hidden("give-up")
OTHER_HAND = button("Other hand", "T")
CHANGE_SCENE = button("Put or take an object")

_KEYS = {
    HOLD: "KeyH",
    ADD_FRAME: "KeyM",
    OTHER_HAND: "KeyT",
    OPEN: "KeyO",
    CLOSE: "KeyC",
}
# The sliders show the target's pose, but the target moves one control period
# after the sliders. Therefore, sliders that a person has just moved are not
# moved back to the target's pose.
_GRACE = 0.5


class TeleopPanel(LeafSystem):
    """Outputs the requests that an operator makes on the page.

    .. pydrake_system::

        name: TeleopPanel
        input_ports:
        - state
        output_ports:
        - command
        - map_requests

    `command` outputs the `OperatorCommand`, and `map_requests` the
    `MapRequests` so far. The system reads the page when these ports are
    evaluated. `state` takes the `TargetState`: the sliders follow the target
    while another source moves it, and a line on the page shows the text of the
    state. If there are several end effectors, a button selects the next one.
    The page has hidden buttons that take or place an object or end a job; its
    list of objects clicks them (`web/task.js`).

    Args:
        page: The page that gets the controls.
        config: The workspace, the saved poses and the gamepad.
        X_WH: Pose of the end effector at the start, shape (4, 4). The angles of
            the sliders are relative to it.
        mapping: Whether there is a live map, which needs buttons.
        scenes: The scenes that a simulated camera can show; it shows the first
            scene at the start. If there are at least two scenes, a button
            switches to the next scene.
        effectors: Names of the robot's end effectors.
        has_hand: Whether there is a hand that opens and closes.
        objects: Names of the objects that may be taken, in the order of the
            page's list.
    """

    def __init__(
        self,
        *,
        page: MeshcatPage,
        config: TeleopConfig,
        X_WH: np.ndarray,
        mapping: bool = True,
        scenes: Sequence[PrimitiveScene] = (),
        effectors: Sequence[str] = ("",),
        has_hand: bool = False,
        objects: Sequence[str] = (),
    ):
        super().__init__()
        self.set_name("teleop_panel")
        self._page = page
        self._config = config
        self._scenes = tuple(scenes)
        self._effectors = tuple(effectors)
        self._choices, self._effector, self._led = 0, 0, 0
        self._takes = {hidden("take", i): x for i, x in enumerate(objects)}
        self._places = {hidden("put", i): x for i, x in enumerate(objects)}
        self._thing, self._support = "", ""
        self._poses = {button(f"→ {name}"): name for name in config.poses}
        self._picks = dict.fromkeys(
            [*self._poses, *self._takes, *self._places], 0
        )
        self._pose = ""
        self._buttons: set[str] = set()
        self._X_WT: np.ndarray | None = None
        self._X_WTs = np.tile(X_WH, (len(effectors), 1, 1))
        self._moves = 0
        self._moved_at = -np.inf
        self._dead_man = DeadMan(page.meshcat, config.gamepad.dead_man)
        self._add_controls(X_WH, mapping, has_hand)
        self._state_input = self.DeclareAbstractInputPort(
            "state", Value(TargetState.at_rest(np.eye(4)))
        )
        for name, value, calc in (
            ("command", Value(OperatorCommand()), self._calc_command),
            ("map_requests", Value(MapRequests()), self._calc_requests),
        ):
            self.DeclareAbstractOutputPort(
                name, value.Clone, calc, {self.time_ticket()}
            )
        self.DeclarePeriodicPublishEvent(PUBLISH_PERIOD, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, page: MeshcatPage, **arguments
    ) -> "TeleopPanel":
        """Adds a panel to a diagram; the caller connects it with the target."""
        return builder.AddSystem(TeleopPanel(page=page, **arguments))

    def _add_controls(self, X_WH: np.ndarray, mapping: bool, has_hand: bool):
        config, meshcat = self._config, self._page.meshcat
        meshcat.AddButton(heading("Target"))
        self._sliders = PoseSliders(
            meshcat, X_WH, config.workspace_lower, config.workspace_upper
        )
        if len(self._effectors) > 1:
            self._add_buttons(OTHER_HAND)
        self._add_buttons(HOLD, HOME, *self._poses)
        if has_hand:
            self._add_buttons(OPEN, CLOSE)
        if self._takes:
            self._add_buttons(GIVE_UP, *self._takes, *self._places)
        if not mapping:
            return
        meshcat.AddButton(heading("Map"))
        self._add_buttons(SCAN, ADD_FRAME, REFINE, UNDO, SAVE)
        if len(self._scenes) > 1:
            self._add_buttons(CHANGE_SCENE)

    def _add_buttons(self, *names: str):
        for name in names:
            self._buttons.add(name)
            self._page.meshcat.AddButton(name, _KEYS.get(name, ""))

    def _clicks(self, name: str) -> int:
        """Returns the number of clicks of a button; 0 if it does not exist."""
        meshcat = self._page.meshcat
        if name not in self._buttons:
            return 0
        return meshcat.GetButtonClicks(name)

    def _calc_command(self, context: Context, output: Value):
        self._read_choices()
        self._read_sliders(context.get_time())
        self._pose = self._picked(self._poses, self._pose)
        self._thing = self._picked(self._takes, self._thing)
        self._support = self._picked(self._places, self._support)
        V_W = self._gamepad_velocity()
        output.set_value(
            OperatorCommand(
                source="sliders" if V_W is None else "gamepad",
                X_WT=self._X_WT,
                moves=self._moves,
                V_W=V_W,
                holds=self._clicks(HOLD) + self._clicks(GIVE_UP),
                homes=self._clicks(HOME),
                pose=self._pose,
                poses=sum(map(self._clicks, self._poses)),
                scans=self._clicks(SCAN),
                opens=self._clicks(OPEN),
                closes=self._clicks(CLOSE),
                thing=self._thing,
                takes=sum(map(self._clicks, self._takes)),
                support=self._support,
                places=sum(map(self._clicks, self._places)),
                effector=self._effectors[self._effector],
                choices=self._choices,
            )
        )

    def _calc_requests(self, context: Context, output: Value):
        output.set_value(
            MapRequests(
                frames=self._clicks(ADD_FRAME),
                refines=self._clicks(REFINE),
                undos=self._clicks(UNDO),
                saves=self._clicks(SAVE),
                scene=scene_in_turn(self._scenes, self._clicks(CHANGE_SCENE)),
            )
        )

    def _read_sliders(self, time: float):
        X_WT = self._sliders.moved()
        if X_WT is not None:
            self._X_WT = X_WT
            self._moves += 1
            self._moved_at = time

    def _read_choices(self):
        clicks = self._clicks(OTHER_HAND)
        if clicks > self._choices:
            next_hand = self._led + clicks - self._choices
            self._effector = self._led = next_hand % len(self._effectors)
            self._choices = clicks
            # The sliders still have the pose of the previously selected hand.
            self._sliders.show(self._X_WTs[self._effector])
            self._X_WT = None

    def _picked(self, names: dict[str, str], before: str) -> str:
        """Returns the value of the button that was clicked last."""
        for name, value in names.items():
            clicks = self._clicks(name)
            if clicks > self._picks[name]:
                self._picks[name] = clicks
                before = value
        return before

    def _gamepad_velocity(self) -> np.ndarray | None:
        if not self._dead_man.is_held():
            return None
        gamepad = self._page.meshcat.GetGamepad()
        return gamepad_velocity(
            gamepad.axes, gamepad.button_values, self._config.gamepad
        )

    def _publish(self, context: Context):
        state = self._state_input.Eval(context)
        text = state.text or state.mode
        if state.X_WTs is not None:
            self._X_WTs, self._led = state.X_WTs, state.effector
            text = f"{self._effectors[state.effector]}: {text}"
        self._page.set_status(text, "target")
        time = context.get_time()
        self._read_sliders(time)
        in_hand = 0 <= time - self._moved_at < _GRACE
        if not in_hand and state.mode != FOLLOW:
            self._sliders.show(state.X_WT)
