"""`Newest`: stores the newest value of each item that a page shows."""

import time
from threading import Condition
from typing import Any

Key = tuple[str, ...]
"""Key of an item on the page: its kind, and its name within the kind."""


class Newest:
    """A store of values from which viewers get only the newest values.

    Each change has a number. A viewer that has drawn all changes up to a number
    requests the changes after that number. A value that was replaced in the
    meantime is never sent, so a slow viewer skips values and does not lag
    behind. The store keeps no data per viewer. It is thread-safe.
    """

    def __init__(self):
        self._entries: dict[Key, tuple[int, Any]] = {}
        self._version = 0
        self._news = Condition()

    def put(self, key: Key, value: Any) -> None:
        """Stores the newest value of an item.

        Args:
            key: Key of the item.
            value: The value, of a JSON type or `bytes`; it must not be changed
                afterwards.
        """
        with self._news:
            known = self._entries.get(key)
            if known is not None and known[1] == value:
                return
            self._version += 1
            self._entries[key] = self._version, value
            self._news.notify_all()

    def drop(self, start: Key) -> None:
        """Removes items from the store.

        New viewers do not get them. Viewers that have drawn them keep the
        drawing.

        Args:
            start: The kind of the items, and a prefix of their names.
        """
        kind, name = start
        with self._news:
            for key in list(self._entries):
                if key[0] == kind and key[1].startswith(name):
                    del self._entries[key]

    def get(self, key: Key) -> Any:
        """Returns the value of an item; None if the store does not have it.

        Args:
            key: Key of the item.
        """
        with self._news:
            known = self._entries.get(key)
        return None if known is None else known[1]

    def of_kind(self, kind: str) -> dict[Key, Any]:
        """Returns all values of a kind.

        Args:
            kind: The first part of the keys.
        """
        with self._news:
            entries = list(self._entries.items())
        return {key: value for key, (_, value) in entries if key[0] == kind}

    def after(
        self, version: int, patience: float = 0.0
    ) -> tuple[int, list[tuple[Key, Any]]]:
        """Returns the changes after a version; waits for one if there is none.

        Args:
            version: Number of the last change that the viewer has drawn; 0 for
                none.
            patience: Longest wait [s].

        Returns:
            Number of the latest change, and the changed values.
        """
        with self._news:
            end = time.monotonic() + patience
            while self._version <= version:
                left = end - time.monotonic()
                if left <= 0:
                    break
                self._news.wait(left)
            changed = [
                (key, value)
                for key, (at, value) in self._entries.items()
                if at > version
            ]
            return self._version, changed
