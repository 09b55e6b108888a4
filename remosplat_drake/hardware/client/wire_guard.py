"""`WireGuard`: detects other controllers or robots on the LCM network.

It identifies the senders on all channels by their addresses. A command of
another sender, or statuses from two senders at once, are a problem until half a
second after the last such message. If the same address also sends a lease or a
report, this message contains the name of the sender. Programs that send no
lease, such as a driver of another project, are also detected.
"""

import dataclasses as dc
import math
import time
from collections.abc import Mapping, Sequence

from pydrake.lcm import DrakeLcm

from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.lease import (
    DRIVER_REPORT,
    LEASE_EXPIRY,
    OPERATOR_REQUEST,
    PERIOD,
    SESSION_LEASE,
    Identity,
    Lease,
    Report,
    decode_lease,
    decode_report,
    decode_request,
    encode_lease,
)
from remosplat_drake.hardware.wire.multicast import MulticastListener, Packet
from remosplat_drake.hardware.wire.packets import BrokenMessage

PRESENT = 0.5
"""A sender counts as present for this time after its last message [s]."""

_FORGOTTEN = 60.0
"""A sender is removed after this time without messages from it [s]."""

_MOST_NAMES = 100
"""The latest leases or reports of at most this many addresses are stored."""


@dc.dataclass
class Senders:
    """The senders of one channel, keyed by address.

    Attributes:
        heard: Time of each sender's last packet [s].
        first: Address of the present sender that sent first.
    """

    heard: dict[str, float] = dc.field(default_factory=dict)
    first: str = ""

    def hear(self, sender: str, now: float) -> None:
        """Records a message of a sender."""
        first = self.heard.get(self.first, -math.inf)
        self.heard[sender] = now
        if not now - first <= LEASE_EXPIRY:
            self.first = sender

    def present(self, now: float) -> list[str]:
        """Returns the present senders, beginning with `first`."""
        there = [s for s, t in self.heard.items() if now - t <= PRESENT]
        return sorted(there, key=lambda sender: sender != self.first)

    def forget(self, now: float) -> None:
        """Removes senders that have been silent for long."""
        for sender, heard in list(self.heard.items()):
            if now - heard > _FORGOTTEN:
                del self.heard[sender]


class Watch:
    """The senders on the network, and the conflicts between them.

    This class uses neither clock nor socket: its methods receive the packets
    and the time.

    Attributes:
        identity: Identity of this process.
        own: This process's address, from its own lease; empty before this lease
            has been received.
        requested_by: Operator that requested motion since the last call of
            `take_request`; None if there is none.
        broken: Number of malformed leases, reports and requests.
        strange: Number of messages that unexpected senders sent on channels of
            commands or statuses, and the channel and address of the latest such
            message.
    """

    def __init__(
        self,
        identity: Identity,
        commands: Sequence[str],
        statuses: Sequence[str],
    ):
        """Starts without senders.

        Args:
            identity: Identity of this process.
            commands: Channels on which only this process may send.
            statuses: Channels with statuses; on each of them, only one driver
                may send.
        """
        self.identity = identity
        self.own = ""
        self.requested_by: str | None = None
        self.broken = 0
        self.strange = 0, ""
        self._commands = {name: Senders() for name in commands}
        self._statuses = {name: Senders() for name in statuses}
        self._drivers: dict[str, Report] = {}
        self._sessions: dict[str, Lease] = {}
        self._told: dict[str, float] = {}
        self._claims = Senders()

    def hear(self, packet: Packet, now: float) -> None:
        """Records the sender of a packet.

        Args:
            packet: A packet of any channel.
            now: Our wall clock [s].
        """
        channel, data, sender, _ = packet
        senders = self._statuses.get(channel) or self._commands.get(channel)
        if senders is not None:
            senders.hear(sender, now)
            ours = self.own if channel in self._commands else senders.first
            if sender != ours:
                self.strange = self.strange[0] + 1, f"{channel} from {sender}"
            return
        try:
            if channel == DRIVER_REPORT:
                self._keep(self._drivers, sender, decode_report(data), now)
            elif channel == SESSION_LEASE:
                self._hear_lease(decode_lease(data), sender, now)
            elif channel == OPERATOR_REQUEST:
                operator = decode_request(data, self.identity.session, now)
                self.requested_by = operator or self.requested_by
        except BrokenMessage:
            self.broken += 1

    def _hear_lease(self, lease: Lease, sender: str, now: float) -> None:
        if lease.identity == self.identity:
            self.own = sender
            return
        self._keep(self._sessions, sender, lease, now)
        if set(lease.drivers) & set(self.drivers(now)):
            self._claims.hear(sender, now)

    def drivers(self, now: float) -> tuple[int, ...]:
        """Returns the sessions of the drivers that send the statuses."""
        sessions = (
            self._drivers[senders.present(now)[0]].identity.session
            for senders in self._statuses.values()
            if senders.present(now) and senders.present(now)[0] in self._drivers
        )
        return tuple(dict.fromkeys(sessions))

    def take_request(self) -> str:
        """Returns the operator that requested motion since the last call."""
        operator, self.requested_by = self.requested_by, None
        return operator or ""

    def problem(self, now: float, *, listens_only: bool = False) -> str:
        """Describes a sender that must not send; empty if there is none.

        Args:
            now: Our wall clock [s].
            listens_only: Whether this process sends no commands. Other programs
                may then send commands.
        """
        if not listens_only:
            channels: Mapping = {**self._commands, SESSION_LEASE: self._claims}
            for channel, senders in channels.items():
                others = [s for s in senders.present(now) if s != self.own]
                if others:
                    other = self._named(others[0])
                    return f"{channel}: {other} also sends commands"
        for channel, senders in self._statuses.items():
            there = senders.present(now)
            if len(there) > 1:
                first, second = map(self._named, there[:2])
                return f"{channel}: has two senders, {first} and {second}"
        return ""

    def _named(self, sender: str) -> str:
        known = self._drivers.get(sender) or self._sessions.get(sender)
        return f"{sender} ({known.identity})" if known else sender

    def tidy(self, now: float) -> None:
        """Removes senders that have been silent for long."""
        for senders in (
            *self._commands.values(),
            *self._statuses.values(),
            self._claims,
        ):
            senders.forget(now)
        # A driver that is restarted has another address.
        for sender, told in list(self._told.items()):
            if now - told > _FORGOTTEN:
                for known in (self._drivers, self._sessions, self._told):
                    known.pop(sender, None)

    def _keep(self, known: dict, sender: str, what, now: float) -> None:
        """Stores the latest lease or report of an address, for at most 100."""
        if sender in known or len(known) < _MOST_NAMES:
            known[sender], self._told[sender] = what, now


class WireGuard:
    """Monitors the network of a robot's link, and sends our lease.

    Attributes:
        sent: Number of messages that this process has sent so far.
        mode: Mode of the supervisor, which the lease contains.
        reason: Reason for that mode.
    """

    def __init__(self, lcm: DrakeLcm, config: HardwareConfig, name: str):
        """Joins the network with another socket, to read senders' addresses.

        Args:
            lcm: The network on which this process sends its commands.
            config: The names of the channels, and the flag of the shadow mode,
                in which nothing is sent, not even a lease.
            name: Name of this program, for display.

        Raises:
            RemoSplatError: The LCM URL is not a multicast address.
        """
        self._lcm, self._shadow = lcm, config.shadow
        self._listener = MulticastListener(config.url)
        names, self._suffix = config.channels, config.suffix
        self._watch = Watch(
            Identity.of_this_process(name),
            (names.arm_command, names.base_command, names.hand_command),
            (
                names.arm_status,
                names.base_status,
                names.hand_status,
                names.localization,
                names.movers,
            ),
        )
        self._commands = False
        self._leased = self._tidied = -math.inf
        self.sent = 0
        self.mode = self.reason = ""

    def listen(self) -> None:
        """Processes new packets, and renews the lease when it is due."""
        now = time.time()
        for packet in self._listener.fetch():
            # Channels with another suffix belong to another robot.
            if packet.channel.endswith(self._suffix):
                name = packet.channel.removesuffix(self._suffix)
                self._watch.hear(packet._replace(channel=name), now)
        if not self._shadow and not 0 <= now - self._leased < PERIOD:
            self._renew(now)
        if not 0 <= now - self._tidied < _FORGOTTEN:
            self._tidied = now
            self._watch.tidy(now)

    def _renew(self, now: float) -> None:
        self._leased = now
        drivers = self._watch.drivers(now) if self._commands else ()
        lease = Lease(
            self._watch.identity, self.sent, self.mode, self.reason, drivers
        )
        self._lcm.Publish(SESSION_LEASE, encode_lease(lease))

    def take_command(self, patience: float) -> str:
        """Claims the drivers by a lease, when no other program commands them.

        Args:
            patience: Longest time to wait until no other program sends commands
                [s].

        Returns:
            The reason why the drivers were not claimed; empty if they were.
        """
        end = time.monotonic() + patience
        while problem := self._objection():
            if time.monotonic() > end:
                return problem
            time.sleep(1e-3)
        self._commands = True
        if not self._shadow:
            self._renew(time.time())
        return ""

    def _objection(self) -> str:
        self.listen()
        if not self._shadow and not self._watch.own:
            return "does not receive its own packets: run `remosplat doctor`"
        return self.problem()

    def problem(self) -> str:
        """Describes a sender that must not send; empty if there is none."""
        return self._watch.problem(time.time(), listens_only=self._shadow)

    def take_request(self) -> str:
        """Returns the operator that requested motion, or ""."""
        return self._watch.take_request()

    def summary(self) -> str:
        """Describes the unexpected messages; empty if there are none."""
        (strange, latest), broken = self._watch.strange, self._watch.broken
        said = []
        if strange and not self._shadow:
            said.append(
                f"{strange} messages of unknown senders, latest {latest}"
            )
        if broken:
            said.append(f"{broken} malformed leases, reports or requests")
        return "; ".join(said)
