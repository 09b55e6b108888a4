"""`Toggle`: a button of the page that changes which objects are visible."""

import dataclasses as dc


@dc.dataclass(frozen=True)
class Toggle:
    """A button that shows another set of objects after each click.

    Each viewer's page has its own state. The button also works after the
    program has ended.

    Attributes:
        label: Text on the button.
        key: Key that clicks the button.
        states: For each state, its name and the paths in the scene tree that
            are visible in it. Paths that belong only to other states are
            hidden.
        initial: Index of the initial state.
    """

    label: str
    key: str
    states: tuple[tuple[str, tuple[str, ...]], ...]
    initial: int = 0

    @property
    def visible(self) -> dict[str, bool]:
        """Whether each path is visible in the initial state."""
        shown = self.states[self.initial][1]
        return {
            path: path in shown for _, paths in self.states for path in paths
        }


def on_off(label: str, key: str, path: str, *, shown: bool = True) -> Toggle:
    """Returns a toggle that shows or hides one path.

    Args:
        label: Text on the button.
        key: Key that clicks the button.
        path: Path of the object in the scene tree.
        shown: Whether the object is visible at first.
    """
    return Toggle(label, key, (("on", (path,)), ("off", ())), int(not shown))
