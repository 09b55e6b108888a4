"""`Authority`: decides which client of the page operates the robot."""

import hmac
import secrets
from collections import Counter

_ALPHABET = "ABCDEFGHJKMNPQRSTVWXYZ23456789"
"""Letters and digits that people do not confuse with each other."""

_GROUPS, _LENGTH = 2, 4
"""Format of the code that a client types: two groups of four characters, so
6.6e11 codes are possible."""

MOST_TRIES = 5
"""A client may type at most this many wrong codes; further codes are
ignored."""


def new_code() -> str:
    """Returns a random code, such as K7QF-2MXD."""
    return "-".join(
        "".join(secrets.choice(_ALPHABET) for _ in range(_LENGTH))
        for _ in range(_GROUPS)
    )


def is_whole(typed: str) -> bool:
    """Returns whether the typed text is as long as a code."""
    return len(_plain(typed)) == _GROUPS * _LENGTH


class Authority:
    """Lets one client operate: the client that has typed the valid code.

    A client that types the valid code becomes the operator. Each code works
    once. While a client operates, no code is valid. When this client hands over
    or leaves, a new code is issued.

    Attributes:
        code: The code that is valid now; empty while a client operates.
        operator: Number of the client that operates; None if no client
            operates.
    """

    def __init__(self):
        """Starts without an operator, with a first code."""
        self.code = new_code()
        self.operator: int | None = None
        self._tries: Counter[int] = Counter()

    def admit(self, client: int, typed: str) -> str:
        """Checks a code that a client typed; the valid code lets it operate.

        Args:
            client: Number of the client.
            typed: The typed text; spaces, dashes and case do not matter.

        Returns:
            Reason of a refusal; empty if the client operates from now on.
        """
        if self.operator == client:
            return ""
        if self.operator is not None:
            return (
                "another browser operates the robot; when it hands over, the "
                "terminal shows a new code"
            )
        if self._tries[client] >= MOST_TRIES:
            return f"{MOST_TRIES} wrong codes: load the page again"
        if not hmac.compare_digest(_plain(typed), _plain(self.code)):
            self._tries[client] += 1
            return "this is not the code that the terminal shows; type it again"
        self.operator, self.code = client, ""
        return ""

    def operates(self, client: int) -> bool:
        """Returns whether a client operates.

        Args:
            client: Number of the client.
        """
        return self.operator == client

    def leave(self, client: int) -> bool:
        """Removes a client that hands over or has closed its page.

        Args:
            client: Number of the client.

        Returns:
            Whether the client was the operator. If so, a new code is issued.
        """
        if self.operator != client:
            return False
        self.operator, self.code = None, new_code()
        return True


def _plain(code: str) -> bytes:
    return code.upper().replace("-", "").replace(" ", "").encode()
