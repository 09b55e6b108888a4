"""`Inbox`: collects the LCM packets that a driver has not processed yet."""

from typing import Protocol

from pydrake.lcm import DrakeLcmInterface


class CommandSource(Protocol):
    """Protocol of a source of a driver's commands."""

    def fetch(self, timeout: float = 0.0) -> list[tuple[str, bytes]]:
        """Removes and returns the messages that have arrived.

        Args:
            timeout: Longest wait for the first message [s].

        Returns:
            Pairs of a channel's name and an encoded message, oldest first.
        """
        ...


class Inbox:
    """Collects encoded LCM messages, in the order of their arrival.

    Drake stores one message per channel, and drops later messages until the
    first one is read. A driver that reads every millisecond receives all
    messages.
    """

    def __init__(self, lcm: DrakeLcmInterface, channels: list[str]):
        """Subscribes to channels.

        Args:
            lcm: The LCM network.
            channels: Names of the channels.
        """
        self._lcm = lcm
        self._waiting: list[tuple[str, bytes]] = []
        for channel in channels:
            lcm.Subscribe(channel, self._keep(channel))

    def _keep(self, channel: str):
        return lambda data: self._waiting.append((channel, bytes(data)))

    def fetch(self, timeout: float = 0.0) -> list[tuple[str, bytes]]:
        """Removes and returns the messages that have arrived.

        Args:
            timeout: Longest wait for the first message [s].

        Returns:
            Pairs of a channel's name and an encoded message, oldest first.
        """
        self._lcm.HandleSubscriptions(round(1e3 * timeout))
        messages, self._waiting[:] = list(self._waiting), []
        return messages
