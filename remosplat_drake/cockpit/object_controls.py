"""`ObjectControls`: the operator's controls to find, take and place objects."""

from collections.abc import Callable, Sequence

import numpy as np
import viser

from remosplat_drake.cockpit.operator_input import OperatorInput
from remosplat_drake.signals.task_outline import TaskOutline


class ObjectControls:
    """A list of objects, and buttons that take and place the chosen object.

    Only the buttons that have an effect are visible: "Make it an object" after
    a click on a surface of the map, "Take it" while the hand is empty, "Put it
    there" while it carries another object, and "Give up" during a job. An
    object that is found is added to the list and chosen.

    Args:
        gui: The operator's panel.
        names: Names of the objects at present.
        inputs: Storage of the operator's requests.

    Attributes:
        folder: The folder that contains the controls.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        names: Sequence[str],
        inputs: OperatorInput,
    ):
        self._inputs = inputs
        self._clicked: tuple[str, np.ndarray] | None = None
        self._point: np.ndarray | None = None
        self._shown: tuple | None = None
        self._outline, self._is_stopped = TaskOutline(), False
        self.folder = gui.add_folder("Objects", order=15.0)
        with self.folder:
            self._choice = gui.add_dropdown("Object", tuple(names))
            self._find = self._button(gui, "Make it an object", self._find_it)
            self._take = self._button(gui, "Take it", self._take_it)
            self._put = self._button(gui, "Put it there", self._put_it)
            self._give_up = self._button(
                gui, "Give up", lambda: inputs.press("holds")
            )
        self._put.visible = self._give_up.visible = False
        self._find.visible = False

        @self._choice.on_update
        async def _(_):
            self._update()

    def _button(
        self, gui: viser.GuiApi, label: str, press: Callable[[], None]
    ) -> viser.GuiButtonHandle:
        button = gui.add_button(label, color="blue")

        @button.on_click
        async def _(_):
            press()

        return button

    def _find_it(self) -> None:
        if self._point is not None:
            self._inputs.find(self._point)
            self._point = None
            self._update()

    def _take_it(self) -> None:
        self._inputs.take(self._choice.value)

    def _put_it(self) -> None:
        name, p_W = self._clicked or ("", None)
        support = self._choice.value
        self._inputs.place(support, p_W if name == support else None)

    def choose(self, name: str, p_W: np.ndarray) -> None:
        """Chooses an object that was clicked in the scene.

        Args:
            name: The object's name.
            p_W: The clicked point, near which a carried object will be placed,
                shape (3,) [m].
        """
        self._clicked, self._point = (name, p_W), None
        self._choice.value = name
        self._update()

    def choose_point(self, p_W: np.ndarray) -> None:
        """Chooses a point of the map, at which an object may be found.

        Args:
            p_W: The clicked point, shape (3,) [m].
        """
        self._point = p_W
        self._update()

    def show(self, outline: TaskOutline, *, is_stopped: bool) -> None:
        """Shows the buttons that have an effect now.

        Args:
            outline: The operator's jobs, with the objects.
            is_stopped: Whether the robot is stopped.
        """
        self._outline, self._is_stopped = outline, is_stopped
        names = tuple(each.name for each in outline.objects)
        known = self._choice.options
        if names and names != known:
            self._choice.options = names
            new = [name for name in names if name not in known]
            self._choice.value = new[-1] if new else self._choice.value
        self._update()

    def _update(self) -> None:
        outline, chosen = self._outline, self._choice.value
        now = outline, self._is_stopped, chosen, self._point is None
        if now == self._shown:
            return
        self._shown = now
        held = next((x.name for x in outline.objects if x.is_carried), "")
        idle = not (outline.is_running or self._is_stopped)
        self._find.visible = idle and self._point is not None
        self._take.visible = idle and not held
        self._put.visible = idle and held not in ("", chosen)
        self._give_up.visible = outline.is_running
