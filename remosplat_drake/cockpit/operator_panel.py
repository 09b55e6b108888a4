"""`OperatorPanel`: the controls of the one client that operates."""

import html
from collections.abc import Callable
from time import monotonic

import numpy as np
import viser

from remosplat_drake.cockpit.ghost import COLOURS, Ghost
from remosplat_drake.cockpit.messages import CockpitJob, PageContent
from remosplat_drake.cockpit.object_controls import ObjectControls
from remosplat_drake.cockpit.offers import LABELS, Offer
from remosplat_drake.cockpit.operator_input import OperatorInput
from remosplat_drake.cockpit.reach import Reach
from remosplat_drake.cockpit.robot_shapes import Shapes, wxyz_position
from remosplat_drake.teleop.gamepad import (
    CLOSE,
    FASTER,
    OPEN,
    SLOWER,
    GamepadState,
    gamepad_presses,
    gamepad_velocity,
)
from remosplat_drake.teleop.pose_coordinates import PoseCoordinates
from remosplat_drake.visualization.page_state import STOPPED

_POSITION_STEP, _ANGLE_STEP = 0.005, 1.0
"""Steps of positions [m] and of angles [°]. The sliders and, at half speed, a
key press have these steps."""
_SPEED, _SPEED_STEP = 50, 10
"""Initial speed of keys and gamepad, and the step by which an operator changes
the speed [%]."""
_SLIDERS = (
    ("x [m]", "S", "W"),
    ("y [m]", "D", "A"),
    ("z [m]", "F", "R"),
    ("roll [°]", "J", "L"),
    ("pitch [°]", "I", "K"),
    ("yaw [°]", "E", "Q"),
)
"""Names of the sliders, and for each the keys that decrease and increase its
value."""

_ANGLES = (180.0, 90.0, 180.0)
_GIZMO = 0.22
_AWAY = 0.05
"""The page draws a translucent robot (ghost) at the target if the hand is
farther from it than this [m]."""
# The sliders show the target's pose, but the target moves one control period
# after the sliders. Therefore, sliders that a person has just moved are not
# moved back to the target's pose.
_GRACE = 0.5
_ANSWER = 5.0
"""Time within which a press of RELEASE must be confirmed [s]."""

Press = Callable[[], None]


class OperatorPanel:
    """The operator's controls: sliders, keys, gizmo, saved poses, map buttons.

    Dragging the gizmo moves the target at once. A click on a surface proposes a
    target in front of it, and shows the robot at this target as a ghost. Then
    gizmo and sliders move the proposal, until the operator confirms or discards
    it.

    Args:
        client: The client that operates.
        job: The settings of the cockpit.
        inputs: Storage of the operator's requests.
        content: The page's content at present.
        shapes: The meshes of the robot's links.
        hand_over: Function that is called when the operator hands over.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        job: CockpitJob,
        inputs: OperatorInput,
        content: PageContent,
        shapes: Shapes,
        hand_over: Press,
    ):
        self._client = client
        self._job = job
        self._inputs = inputs
        self._content = content
        self._chosen, self._chosen_at = content.effector, -np.inf
        self._coordinates = self._coordinates_of(content.effector)
        self._proposal: np.ndarray | None = None
        self._moved_at = self._asked_at = -np.inf
        self._pressed: frozenset[str] = frozenset()
        self._parts: list[viser.GuiButtonHandle | viser.GuiFolderHandle] = []
        self._commands: list[viser.CommandHandle] = []
        # RELEASE is far from STOP and needs a confirmation, so that a person
        # does not press it by accident.
        self._release = self._button(
            client.gui, "RELEASE", self._ask, color="orange", order=80.0
        )
        self._let_go = self._button(
            client.gui,
            "Let the robot go",
            self._free,
            color="orange",
            order=81.0,
        )
        self._let_go.visible = False
        self._add_target()
        if job.mapping:
            self._add_map()
        self._objects: ObjectControls | None = None
        if content.objects:
            names = [each.name for each in content.objects]
            self._objects = ObjectControls(client.gui, names, inputs)
            self._parts.append(self._objects.folder)
        self._parts.append(
            self._button(client.gui, "Hand over", hand_over, order=90.0)
        )
        self._gizmo = self._add_gizmo()
        self._ghost = Ghost(client.scene, job.robot, shapes)
        self.show(content)

    def _coordinates_of(self, effector: int) -> PoseCoordinates:
        job = self._job
        return PoseCoordinates(job.robot.end_effector_pose(job.q0, effector))

    def _button(
        self,
        gui: viser.GuiApi,
        label: str,
        press: Press,
        hotkey: str | None = None,
        **style,
    ) -> viser.GuiButtonHandle:
        """Adds a button, and a key that has the same effect."""
        hint = f"key {hotkey}" if hotkey else None
        style.setdefault("color", "indigo")
        button = gui.add_button(label, hint=hint, **style)

        @button.on_click
        async def _(_):
            press()

        if hotkey:
            self._key(label, hotkey, press)
        return button

    def _ask(self) -> None:
        # `show`, in another thread, hides the button when the time is over.
        self._asked_at = monotonic()
        self._let_go.visible = True

    def _free(self) -> None:
        self._let_go.visible = False
        self._inputs.release()

    def _key(self, label: str, hotkey: str, press: Press) -> None:
        command = self._client.gui.add_command(label, hotkey=hotkey)

        @command.on_trigger
        async def _(_):
            press()

        self._commands.append(command)

    def _add_target(self) -> None:
        gui, inputs = self._client.gui, self._inputs
        folder = gui.add_folder("Target", order=10.0)
        self._parts.append(folder)
        with folder:
            self._verdict = gui.add_html("", visible=False)
            self._go = self._button(
                gui, "Go there", self._go_there, "G", color="blue"
            )
            self._discard = self._button(gui, "Discard", self._drop, "X")
            self._go.visible = self._discard.visible = False
            self._offers: tuple[Offer, ...] = ()
            self._offer_buttons = [self._offer_button(gui, x) for x in LABELS]
            if len(self._job.robot.effectors) > 1:
                self._hand = self._add_choice(gui)
            # Requests to a stopped robot are ignored.
            self._motions = [
                self._button(gui, "Hold", lambda: inputs.press("holds"), "H"),
                self._button(gui, "Go home", lambda: inputs.press("homes")),
                *(
                    self._button(gui, f"→ {name}", self._picking(name))
                    for name in self._job.config.poses
                ),
            ]
            self._add_hand(gui)
            self._speed = gui.add_slider(
                "Speed [%]",
                min=_SPEED_STEP,
                max=100,
                step=_SPEED_STEP,
                initial_value=_SPEED,
                hint="of keys and gamepad; keys Z and V",
            )
            self._key("Slower", "Z", lambda: self._change_speed(-_SPEED_STEP))
            self._key("Faster", "V", lambda: self._change_speed(_SPEED_STEP))
            with gui.add_folder("By the numbers", expand_by_default=False):
                self._sliders = self._add_sliders(gui)

    def _offer_button(
        self, gui: viser.GuiApi, label: str
    ) -> viser.GuiButtonHandle:
        """Adds a hidden button, which will propose an alternative target."""

        def propose():
            for offer in self._offers:
                if offer.label == label:
                    self.propose(offer.X_WT)

        button = self._button(gui, label, propose, color="teal")
        button.visible = False
        return button

    def _add_hand(self, gui: viser.GuiApi) -> None:
        """Adds the buttons of the robot's hand, if it has one."""
        if self._job.robot.description.hand is None:
            return
        press = self._inputs.press
        self._motions += [
            self._button(gui, "Open hand", lambda: press("opens"), "O"),
            self._button(gui, "Close hand", lambda: press("closes"), "C"),
        ]

    @property
    def _gamepad_does(self) -> dict[str, Press]:
        """The functions that a gamepad calls, keyed by the gamepad's action."""
        press = self._inputs.press
        return {
            OPEN: lambda: press("opens"),
            CLOSE: lambda: press("closes"),
            FASTER: lambda: self._change_speed(_SPEED_STEP),
            SLOWER: lambda: self._change_speed(-_SPEED_STEP),
        }

    def _change_speed(self, step: int) -> None:
        speed = self._speed
        speed.value = int(np.clip(speed.value + step, speed.min, speed.max))

    def lead(self, gamepad: GamepadState | None) -> None:
        """Moves the target and the hand as a gamepad requests.

        Args:
            gamepad: State of the gamepad; None without a gamepad.
        """
        pad, config = gamepad or GamepadState(), self._job.config.gamepad
        presses = gamepad_presses(pad.buttons, config)
        new, self._pressed = presses - self._pressed, presses
        for does in new:
            self._gamepad_does[does]()
        V_W = gamepad_velocity(pad.axes, pad.buttons, config)
        if V_W is not None:
            V_W = 0.01 * self._speed.value * V_W
        self._inputs.lead(V_W)

    def _add_choice(self, gui: viser.GuiApi) -> viser.GuiDropdownHandle:
        """Adds a selector of the hand that all other controls move."""
        names = self._job.robot.effectors
        hand = gui.add_dropdown(
            "Hand", names, initial_value=names[self._chosen], hint="key T"
        )

        @hand.on_update
        async def _(event: viser.GuiEvent):
            if event.client is not None:
                self._choose(names.index(hand.value))

        self._key("Next hand", "T", lambda: self._choose(self._chosen + 1))
        return hand

    def _choose(self, effector: int) -> None:
        """Selects a hand by its index; after the last hand comes the first."""
        names = self._job.robot.effectors
        effector %= len(names)
        if effector != self._chosen:
            self._chosen_at = monotonic()
            self._inputs.choose(names[effector])
            self._show_hand(effector)

    def _show_hand(self, effector: int) -> None:
        """Switches all controls to the chosen hand."""
        self._chosen = effector
        self._drop()
        self._coordinates = self._coordinates_of(effector)
        self._hand.value = self._job.robot.effectors[effector]
        if self._content.X_WTs is not None:
            self._place(self._content.X_WTs[effector])

    def _picking(self, name: str) -> Press:
        return lambda: self._inputs.pick(name)

    def _add_sliders(self, gui: viser.GuiApi) -> list[viser.GuiSliderHandle]:
        config = self._job.config
        begin = self._coordinates.of(self._content.X_WT)
        ends = list(
            zip(config.workspace_lower, config.workspace_upper, strict=True)
        )
        ends += [(-angle, angle) for angle in _ANGLES]
        sliders = []
        for i, (name, less, more) in enumerate(_SLIDERS):
            step = _POSITION_STEP if i < 3 else _ANGLE_STEP
            low, high = ends[i]
            slider = gui.add_slider(
                name,
                min=low,
                max=high,
                step=step,
                initial_value=float(np.clip(begin[i], low, high)),
                hint=f"keys {less} and {more}",
            )
            self._listen(slider)
            self._key(f"{name} less", less, self._nudging(i, -step))
            self._key(f"{name} more", more, self._nudging(i, step))
            sliders.append(slider)
        return sliders

    def _listen(self, slider: viser.GuiSliderHandle) -> None:
        @slider.on_update
        async def _(event: viser.GuiEvent):
            # Changes that the server itself has made are ignored.
            if event.client is not None:
                values = [float(s.value) for s in self._sliders]
                self._move(self._coordinates.pose(np.array(values)))

    def _nudging(self, axis: int, step: float) -> Press:
        def nudge():
            values = self._coordinates.of(self._desired_pose())
            values[axis] += step * self._speed.value / _SPEED
            self._move(self._coordinates.pose(values))

        return nudge

    def _add_map(self) -> None:
        gui, inputs = self._client.gui, self._inputs
        folder = gui.add_folder("Map", order=20.0)
        self._parts.append(folder)
        with folder:
            self._button(gui, "Scan", lambda: inputs.press("scans"))
            self._button(
                gui,
                "Add a frame",
                lambda: inputs.request("frames"),
                "M",
            )
            self._button(gui, "Refine", lambda: inputs.request("refines"))
            self._button(gui, "Undo", lambda: inputs.request("undos"))
            self._button(gui, "Save splat", lambda: inputs.request("saves"))
            if len(self._job.scenes) > 1:
                self._button(gui, "Put or take an object", inputs.change_scene)

    def _add_gizmo(self) -> viser.TransformControlsHandle:
        wxyz, position = wxyz_position(self._content.X_WT)
        gizmo = self._client.scene.add_transform_controls(
            "/gizmo",
            scale=_GIZMO,
            depth_test=False,
            wxyz=wxyz,
            position=position,
        )

        @gizmo.on_update
        async def _(event: viser.TransformControlsEvent):
            if event.client is not None:
                self._move(_pose(gizmo.wxyz, gizmo.position), by_gizmo=True)

        return gizmo

    def propose(self, X_WT: np.ndarray) -> None:
        """Proposes a target; the robot moves to it only if the operator agrees.

        Args:
            X_WT: The target, shape (4, 4).
        """
        self._proposal = X_WT
        self._place(X_WT)
        self._go.visible = self._discard.visible = True

    def point_at(self, name: str, p_W: np.ndarray) -> None:
        """Chooses an object that the operator has clicked.

        Args:
            name: Name of the object.
            p_W: The clicked point, shape (3,) [m].
        """
        if self._objects is not None:
            self._objects.choose(name, p_W)

    def point_at_map(self, p_W: np.ndarray) -> None:
        """Chooses a point of the map that the operator has clicked.

        Args:
            p_W: The point, which is on no object, shape (3,) [m].
        """
        if self._objects is not None:
            self._objects.choose_point(p_W)

    def _go_there(self) -> None:
        if self._proposal is not None:
            X_WT = self._proposal
            self._drop()
            self._move(X_WT)

    def _drop(self) -> None:
        self._proposal = None
        self._go.visible = self._discard.visible = False
        self.withdraw()
        desired = self._inputs.X_WT if self._content.is_followed else None
        self._place(self._content.X_WT if desired is None else desired)

    def _desired_pose(self) -> np.ndarray:
        """Pose of gizmo and sliders, shape (4, 4)."""
        return _pose(self._gizmo.wxyz, self._gizmo.position)

    def _move(self, X_WT: np.ndarray, *, by_gizmo: bool = False) -> None:
        """Moves the proposed target if there is a proposal, else the target."""
        # Until the next update, gizmo and sliders still have the pose of the
        # previously selected hand.
        if (
            not np.isfinite(X_WT).all()
            or self._content.effector != self._chosen
        ):
            return
        self._moved_at = monotonic()
        if self._proposal is not None:
            self._proposal = X_WT
        else:
            self._inputs.move(X_WT)
        self._place(X_WT, gizmo=not by_gizmo)

    def _place(self, X_WT: np.ndarray, *, gizmo: bool = True) -> None:
        """Moves gizmo and sliders to a pose."""
        if gizmo:
            self._gizmo.wxyz, self._gizmo.position = wxyz_position(X_WT)
        values = self._coordinates.of(X_WT)
        for slider, value in zip(self._sliders, values, strict=True):
            value = float(np.clip(value, slider.min, slider.max))
            if abs(value - slider.value) > 0.51 * slider.step:
                slider.value = value

    def show(self, content: PageContent) -> None:
        """Shows the run's state at one moment.

        Args:
            content: The page's content at that moment.
        """
        self._content = content
        can_release = "release" in content.state.buttons
        if self._release.visible != can_release:
            self._release.visible = can_release
        if self._let_go.visible:
            is_late = monotonic() - self._asked_at > _ANSWER
            if is_late or not can_release:
                self._let_go.visible = False
        is_stopped = content.state.phase == STOPPED
        if self._objects is not None:
            self._objects.show(content.outline, is_stopped=is_stopped)
        for button in self._motions:
            if button.disabled != is_stopped:
                button.disabled = is_stopped
        if content.effector != self._chosen:
            if monotonic() - self._chosen_at < _GRACE:
                return
            self._show_hand(content.effector)  # Another source has chosen.
        in_hand = monotonic() - self._moved_at < _GRACE
        if self._proposal is None and not (in_hand or content.is_followed):
            self._place(content.X_WT)

    @property
    def question(self) -> np.ndarray | None:
        """The target for which a configuration is searched.

        Shape (4, 4); None if there is no target to test.
        """
        if self._proposal is not None:
            return self._proposal
        X_WT, p_WE = self._desired_pose(), self._content.X_WE[:3, 3]
        is_away = np.linalg.norm(X_WT[:3, 3] - p_WE) > _AWAY
        return X_WT if self._content.is_followed and is_away else None

    def answer(self, reach: Reach, X_WT: np.ndarray) -> None:
        """Shows whether a target can be reached.

        Args:
            reach: The result of the search for a configuration.
            X_WT: The tested target, shape (4, 4).
        """
        self._ghost.show(reach, X_WT)
        self._verdict.content = verdict_html(reach)
        self._verdict.visible = True

    @property
    def proposes(self) -> bool:
        """Whether a proposed target waits for the operator to confirm it."""
        return self._proposal is not None

    def offer(self, offers: tuple[Offer, ...]) -> None:
        """Shows a button for each alternative target; a click proposes it.

        Args:
            offers: The alternative targets, at most one of each label.
        """
        if offers is self._offers:
            return
        self._offers = offers
        labels = {offer.label for offer in offers}
        for label, button in zip(LABELS, self._offer_buttons, strict=True):
            if button.visible != (label in labels):
                button.visible = label in labels

    def withdraw(self) -> None:
        """Hides the ghost and the verdict."""
        self._ghost.hide()
        self._verdict.visible = False

    def remove(self) -> None:
        """Removes all of the operator's controls."""
        for part in (self._release, self._let_go, *self._parts):
            part.remove()
        for command in self._commands:
            command.remove()
        self._gizmo.remove()
        self._ghost.remove()


def verdict_html(reach: Reach) -> str:
    """Returns the verdict of a search as HTML, in the colour of its ghost.

    Args:
        reach: The result of the search for a configuration.
    """
    red, green, blue = COLOURS[reach.verdict]
    return (
        '<div style="margin:0 10px 6px;padding:6px 10px;border-radius:6px;'
        f'font-size:13px;color:white;background:rgb({red},{green},{blue})">'
        f"<b>{reach.verdict.capitalize()}</b>: {html.escape(reach.text)}</div>"
    )


def _pose(wxyz: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Returns the pose of a viser node, shape (4, 4); NaN if it is invalid."""
    w, x, y, z = np.asarray(wxyz, float)
    n = np.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = (v / n if n > 0 else np.nan for v in (w, x, y, z))
    X = np.eye(4)
    X[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    X[:3, 3] = position
    return X
