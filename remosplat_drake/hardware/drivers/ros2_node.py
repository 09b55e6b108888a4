"""`Ros2Node`: reads and writes ROS 2 topics by CycloneDDS."""

import contextlib
import os
import re
from collections.abc import Iterator

from remosplat_drake.base.errors import (
    FieldError,
    MissingExtraError,
    RemoSplatError,
)

_MOST = 100
"""At most this many samples are read at once."""

_MOST_ENDPOINTS = 10_000
"""At most this many readers of a domain are examined."""

_LAST_DOMAIN = 232
"""Largest ROS_DOMAIN_ID; for larger numbers, DDS has no UDP ports."""


def environment_domain() -> int:
    """Returns ROS_DOMAIN_ID, or 0.

    Raises:
        FieldError: ROS_DOMAIN_ID is not a number from 0 to 232.
    """
    text = os.environ.get("ROS_DOMAIN_ID", "") or "0"
    if not re.fullmatch(r"\d{1,3}", text) or int(text) > _LAST_DOMAIN:
        problem = f"expected a number from 0 to {_LAST_DOMAIN}, got {text!r}"
        raise FieldError("environment", "ROS_DOMAIN_ID", problem)
    return int(text)


class Ros2Node:
    """A participant of a ROS 2 domain.

    Its writers are reliable, and its readers are best-effort. So they are
    compatible with all writers and readers of other programs.
    """

    def __init__(self, domain: int | None, what: str):
        """Joins a ROS 2 domain.

        Args:
            domain: The robot's ROS_DOMAIN_ID; None takes the value of the
                environment variable, or 0.
            what: Name of the feature that needs CycloneDDS; errors contain this
                name.

        Raises:
            RemoSplatError: CycloneDDS is not installed or finds no network, or
                ROS_DOMAIN_ID is not a number.
        """
        domain = environment_domain() if domain is None else domain
        try:
            from cyclonedds.domain import DomainParticipant
        except ImportError as error:
            raise MissingExtraError(what, "ros2") from error
        self._domain = domain
        with self._named_errors():
            self._participant = DomainParticipant(domain)
        self._subscriptions = None

    def writer(self, topic: str, kind: type, *, latched: bool = False):
        """Makes a `DataWriter` of a topic, which keeps its last message.

        Args:
            topic: ROS's name of the topic.
            kind: Type of its messages, one of `ros2_messages`.
            latched: Whether the last message is also sent to readers that start
                later (ROS's transient local).

        Raises:
            RemoSplatError: The topic cannot be written.
        """
        from cyclonedds.core import Policy, Qos
        from cyclonedds.pub import DataWriter

        from remosplat_drake.hardware.drivers.ros2_messages import dds_topic

        qos = Qos(
            Policy.Reliability.Reliable(max_blocking_time=10_000_000),
            Policy.Durability.TransientLocal
            if latched
            else Policy.Durability.Volatile,
            Policy.History.KeepLast(1),
        )
        return self._made(DataWriter, dds_topic(topic), kind, qos)

    def request_writer(self, service: str, kind: type):
        """Makes a `DataWriter` of a service's requests.

        Args:
            service: ROS's name of the service.
            kind: Type of its requests.

        Raises:
            RemoSplatError: The topic cannot be written.
        """
        from cyclonedds.pub import DataWriter

        from remosplat_drake.hardware.drivers.ros2_messages import request_topic

        name = request_topic(service)
        return self._made(DataWriter, name, kind, _service_qos())

    def request_reader(self, service: str, kind: type):
        """Makes a `DataReader` of a service's requests.

        Args:
            service: ROS's name of the service.
            kind: Type of its requests.

        Raises:
            RemoSplatError: The topic cannot be read.
        """
        from cyclonedds.sub import DataReader

        from remosplat_drake.hardware.drivers.ros2_messages import request_topic

        name = request_topic(service)
        return self._made(DataReader, name, kind, _service_qos())

    def servers(self, service: str) -> list[bytes]:
        """Returns the DDS vendors of a service's present servers.

        A vendor is two bytes, the first ones of the GUIDs of its participants.

        Args:
            service: ROS's name of the service.
        """
        from cyclonedds.builtin import (
            BuiltinDataReader,
            BuiltinTopicDcpsSubscription,
        )

        from remosplat_drake.hardware.drivers.ros2_messages import request_topic

        with self._named_errors():
            if self._subscriptions is None:
                self._subscriptions = BuiltinDataReader(
                    self._participant, BuiltinTopicDcpsSubscription
                )
            found = self._subscriptions.read(N=_MOST_ENDPOINTS)
        return [
            endpoint.participant_key.bytes[:2]
            for endpoint in found
            if endpoint.sample_info.valid_data
            and endpoint.topic_name == request_topic(service)
        ]

    def reader(self, topic: str, kind: type, *, latched: bool = False):
        """Makes a `DataReader` of a topic, which keeps the last ten messages.

        Args:
            topic: ROS's name of the topic.
            kind: Type of its messages, one of `ros2_messages`.
            latched: Whether to read the last message of writers that started
                earlier. Then only writers that keep it (ROS's transient local)
                are accepted.

        Raises:
            RemoSplatError: The topic cannot be read.
        """
        from cyclonedds.core import Policy, Qos
        from cyclonedds.sub import DataReader

        from remosplat_drake.hardware.drivers.ros2_messages import dds_topic

        history = Policy.History.KeepLast(10)
        qos = Qos(Policy.Reliability.BestEffort, history)
        if latched:
            qos = Qos(
                Policy.Reliability.Reliable(max_blocking_time=10_000_000),
                Policy.Durability.TransientLocal,
                history,
            )
        return self._made(DataReader, dds_topic(topic), kind, qos)

    def _made(self, end: type, name: str, kind: type, qos):
        """Makes a `DataWriter` or `DataReader` of a topic with a DDS name."""
        from cyclonedds.topic import Topic

        with self._named_errors():
            topic = Topic(self._participant, name, kind)
            return end(self._participant, topic, qos=qos)

    @contextlib.contextmanager
    def _named_errors(self) -> Iterator[None]:
        from cyclonedds.core import DDSException

        try:
            yield
        except DDSException as error:
            raise RemoSplatError(
                f"DDS domain {self._domain}: {error}"
            ) from error


def _service_qos():
    from cyclonedds.core import Policy, Qos

    return Qos(
        Policy.Reliability.Reliable(max_blocking_time=10_000_000),
        Policy.Durability.Volatile,
        Policy.History.KeepLast(10),
    )


def taken(reader) -> list:
    """Returns a reader's new messages, oldest first; none without a reader."""
    samples = [] if reader is None else reader.take(N=_MOST)
    return [sample for sample in samples if sample.sample_info.valid_data]
