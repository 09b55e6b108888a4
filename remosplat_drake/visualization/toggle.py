"""`Toggle`: a button of the page that steps through states."""

from collections.abc import Sequence

from pydrake.geometry import Meshcat

from remosplat_drake.visualization import page_style


class Toggle:
    """A button that shows another set of objects after each click.

    Meshcat counts clicks on the server's side; somebody has to `poll` them.

    Args:
        meshcat: The page's Meshcat server.
        label: What the button says.
        keycode: Key that clicks it, for example "Digit1".
        states: Paths in the scene tree that are visible in each state; the
            paths of all other states are hidden then.
        initial: Index of the state to begin with.

    Attributes:
        name: Name of the button on Meshcat.
        label: What the button says.
        key: Key that clicks it.
        states: Paths that are visible in each state.
    """

    def __init__(
        self,
        meshcat: Meshcat,
        *,
        label: str,
        keycode: str,
        states: Sequence[Sequence[str]],
        initial: int = 0,
    ):
        self._meshcat = meshcat
        self.label = label
        self.key = keycode.removeprefix("Digit")
        self.name = page_style.toggle(label, self.key)
        self.states = tuple(tuple(paths) for paths in states)
        self._paths = sorted({path for paths in states for path in paths})
        self._initial = initial
        meshcat.AddButton(self.name, keycode)
        self._show(initial)

    @property
    def state(self) -> int:
        """Index of the present state."""
        return self._state

    def poll(self):
        """Counts the clicks, and shows the state that they lead to."""
        clicks = self._meshcat.GetButtonClicks(self.name)
        state = (self._initial + clicks) % len(self.states)
        if state != self._state:
            self._show(state)

    def _show(self, state: int):
        self._state = state
        for path in self._paths:
            visible = path in self.states[state]
            self._meshcat.SetProperty(path, "visible", visible)
