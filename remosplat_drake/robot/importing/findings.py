"""`Findings`: facts, guesses and doubts of an import."""

import dataclasses as dc


@dc.dataclass
class Findings:
    """Three lists of pairs (subject, value), in their order of discovery.

    Attributes:
        found: Content of the robot's files.
        guessed: Values that they do not contain, and that were guessed; a
            person should check them.
        doubted: Values that they contain, that were used, and that are hardly
            right.
    """

    found: list[tuple[str, str]] = dc.field(default_factory=list)
    guessed: list[tuple[str, str]] = dc.field(default_factory=list)
    doubted: list[tuple[str, str]] = dc.field(default_factory=list)

    def find(self, what: str, value: str) -> None:
        """Adds a value of a file.

        Args:
            what: Its subject, such as `velocity limits`.
            value: The file's value.
        """
        self.found.append((what, value))

    def guess(self, what: str, value: str) -> None:
        """Adds a guess.

        Args:
            what: Its subject, such as `acceleration limits`.
            value: The guess, and its reason.
        """
        self.guessed.append((what, value))

    def doubt(self, what: str, value: str) -> None:
        """Adds a value of a file that is hardly right.

        Args:
            what: Its subject, such as a joint.
            value: The doubt, and its possible cause.
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
