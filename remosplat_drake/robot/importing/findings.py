"""`Findings`: the found, guessed and doubted values of an import."""

import dataclasses as dc


@dc.dataclass
class Findings:
    """Three lists of pairs (subject, value), in their order of discovery.

    Attributes:
        found: Values from the robot's files.
        guessed: Guesses of values that the files do not contain; a person
            should check them.
        doubted: Values from the files that the import uses although they are
            probably wrong.
    """

    found: list[tuple[str, str]] = dc.field(default_factory=list)
    guessed: list[tuple[str, str]] = dc.field(default_factory=list)
    doubted: list[tuple[str, str]] = dc.field(default_factory=list)

    def find(self, what: str, value: str) -> None:
        """Adds a value of a file.

        Args:
            what: Subject of the value, such as `velocity limits`.
            value: The file's value.
        """
        self.found.append((what, value))

    def guess(self, what: str, value: str) -> None:
        """Adds a guess.

        Args:
            what: Subject of the guess, such as `acceleration limits`.
            value: The guess, and its reason.
        """
        self.guessed.append((what, value))

    def doubt(self, what: str, value: str) -> None:
        """Adds a value of a file that is probably wrong.

        Args:
            what: Subject of the value, such as a joint.
            value: The doubt, and its possible cause.
        """
        self.doubted.append((what, value))


def listed(names: list[str], most: int = 6) -> str:
    """Formats a list of names; replaces the end of a long list by a number.

    Args:
        names: The names.
        most: Largest number of names that are listed.
    """
    shown = ", ".join(names[:most])
    more = len(names) - most
    return f"{shown} and {more} more" if more > 0 else shown
