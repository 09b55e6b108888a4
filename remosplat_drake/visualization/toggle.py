"""`Toggle`: a button of the page that steps through states."""

import dataclasses as dc


@dc.dataclass(frozen=True)
class Toggle:
    """A button that shows another set of objects after each click.

    The page steps through the states by itself, so each onlooker has states
    of their own, which last when the program has ended.

    Attributes:
        label: What the button is about.
        key: Key that clicks it.
        states: Name of each state, and the paths in the scene tree that are
            visible in it; the paths of all other states are hidden then.
        initial: Index of the state to begin with.
    """

    label: str
    key: str
    states: tuple[tuple[str, tuple[str, ...]], ...]
    initial: int = 0

    @property
    def visible(self) -> dict[str, bool]:
        """Whether each path is visible to begin with."""
        shown = self.states[self.initial][1]
        return {
            path: path in shown for _, paths in self.states for path in paths
        }


def on_off(label: str, key: str, path: str, *, shown: bool = True) -> Toggle:
    """Returns a toggle that shows or hides one thing.

    Args:
        label: What the button is about.
        key: Key that clicks it.
        path: Path of the thing in the scene tree.
        shown: Whether it is visible to begin with.
    """
    return Toggle(label, key, (("on", (path,)), ("off", ())), int(not shown))
