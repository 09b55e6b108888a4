"""`Findings`: facts, guesses and doubts of an import."""

import dataclasses as dc


@dc.dataclass
class Findings:
    """Three lists of pairs (what, value), in the order in which they came up.

    Attributes:
        found: What the robot's files say.
        guessed: What they do not say, and was made up; a person should look.
        doubted: What they say, was taken, and can hardly be true.
    """

    found: list[tuple[str, str]] = dc.field(default_factory=list)
    guessed: list[tuple[str, str]] = dc.field(default_factory=list)
    doubted: list[tuple[str, str]] = dc.field(default_factory=list)

    def find(self, what: str, value: str) -> None:
        """Notes what a file says.

        Args:
            what: What it is about, such as `velocity limits`.
            value: What the file says of it.
        """
        self.found.append((what, value))

    def guess(self, what: str, value: str) -> None:
        """Notes what was made up.

        Args:
            what: What it is about, such as `acceleration limits`.
            value: What is taken for it, and why.
        """
        self.guessed.append((what, value))

    def doubt(self, what: str, value: str) -> None:
        """Notes what a file says and can hardly be true.

        Args:
            what: What it is about, such as a joint.
            value: What is odd about it, and what may be wrong.
        """
        self.doubted.append((what, value))


def listed(names: list[str], most: int = 6) -> str:
    """Words a list of names, the rest of a long one as a number.

    Args:
        names: The names.
        most: How many are named.
    """
    shown = ", ".join(names[:most])
    more = len(names) - most
    return f"{shown} and {more} more" if more > 0 else shown
