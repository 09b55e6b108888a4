"""Other programs on the wire, found by packets and their senders."""

import time

import pytest
from pydrake.lcm import DrakeLcm

from remosplat_drake.acceptance.hardware_processes import free_url, wire_works
from remosplat_drake.hardware.client.operator import Operator
from remosplat_drake.hardware.client.wire_guard import (
    PRESENT,
    Watch,
    WireGuard,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.lease import (
    DRIVER_REPORT,
    OPERATOR_REQUEST,
    SESSION_LEASE,
    Identity,
    Lease,
    Report,
    encode_lease,
    encode_report,
    encode_request,
)
from remosplat_drake.hardware.wire.multicast import Packet

US = Identity(1, 10, "lab", "ours")
THEM = Identity(2, 20, "lab", "theirs")
PANDA = Identity(5, 50, "rt", "panda-driver")
OTHER = Identity(6, 60, "rt", "hardware-sim")

OUR, THEIR, ARM, ARM_2 = "a:1", "b:2", "c:3", "d:4"
COMMAND, STATUS = "PANDA_COMMAND", "PANDA_STATUS"


def watch(*packets: tuple[str, bytes, str]) -> Watch:
    """What hears our lease and these packets at time 0."""
    made = Watch(US, [COMMAND], [STATUS])
    lease = SESSION_LEASE, encode_lease(Lease(US)), OUR
    for packet in (lease, *packets):
        made.hear(Packet(*packet), 0.0)
    return made


def report(identity: Identity, sender: str) -> tuple[str, bytes, str]:
    return DRIVER_REPORT, encode_report(Report(identity)), sender


def lease_of(identity: Identity, sender: str, *drivers: int):
    return SESSION_LEASE, encode_lease(Lease(identity, drivers=drivers)), sender


def test_alone_with_a_robot_nothing_is_wrong():
    alone = watch((COMMAND, b"", OUR), (STATUS, b"", ARM), report(PANDA, ARM))
    assert alone.problem(0.0) == ""
    assert alone.drivers(0.0) == (PANDA.session,)


def test_a_foreign_command_is_named_by_address_and_lease():
    stranger = watch((COMMAND, b"", THEIR))
    assert stranger.problem(0.0) == f"{COMMAND}: {THEIR} also sends commands"
    known = watch((COMMAND, b"", THEIR), lease_of(THEM, THEIR))
    assert "b:2 (theirs, pid 20 on lab)" in known.problem(0.0)


def test_messages_of_strangers_are_counted_and_named():
    heard = watch(
        (COMMAND, b"", OUR), (STATUS, b"", ARM), (COMMAND, b"", THEIR)
    )
    assert heard.strange == (1, f"{COMMAND} from {THEIR}")
    heard.hear(Packet(STATUS, b"", ARM_2), 0.1)
    assert heard.strange == (2, f"{STATUS} from {ARM_2}")


def test_a_problem_lasts_as_long_as_the_sender_is_there():
    stranger = watch((COMMAND, b"", THEIR))
    assert stranger.problem(PRESENT)
    assert not stranger.problem(PRESENT + 0.01)


def test_a_session_that_claims_our_drivers_is_foreign_before_it_commands():
    statuses = (STATUS, b"", ARM), report(PANDA, ARM)
    claims = watch(*statuses, lease_of(THEM, THEIR, PANDA.session))
    assert claims.problem(0.0).startswith(f"{SESSION_LEASE}: {THEIR}")
    waits = watch(*statuses, lease_of(THEM, THEIR))
    elsewhere = watch(*statuses, lease_of(THEM, THEIR, OTHER.session))
    assert waits.problem(0.0) == elsewhere.problem(0.0) == ""


def test_a_second_robot_is_named_and_not_claimed():
    two = watch(
        (STATUS, b"", ARM),
        report(PANDA, ARM),
        (STATUS, b"", ARM_2),
        report(OTHER, ARM_2),
        (STATUS, b"", ARM),
    )
    assert two.problem(0.0) == (
        f"{STATUS}: has two senders, c:3 (panda-driver, pid 50 on rt) and d:4"
        " (hardware-sim, pid 60 on rt)"
    )
    assert two.drivers(0.0) == (PANDA.session,)


def test_a_driver_that_was_restarted_takes_the_place_of_the_old_one():
    again = watch((STATUS, b"", ARM), report(PANDA, ARM))
    again.hear(Packet(*report(OTHER, ARM_2)), 3.0)
    again.hear(Packet(STATUS, b"", ARM_2), 3.0)
    assert again.problem(3.0) == ""
    assert again.drivers(3.0) == (OTHER.session,)


def test_new_addresses_of_an_interface_are_no_other_programs():
    """After half a second, in which the old addresses count as present."""
    ours = watch((COMMAND, b"", OUR), (STATUS, b"", ARM), report(PANDA, ARM))
    ours.hear(Packet(COMMAND, b"", "a:9"), 0.1)
    assert ours.problem(0.1) == f"{COMMAND}: a:9 also sends commands"
    for packet in (
        lease_of(US, "a:9"),
        (COMMAND, b"", "a:9"),
        (STATUS, b"", "c:9"),
        report(PANDA, "c:9"),
    ):
        ours.hear(Packet(*packet), PRESENT + 0.1)
    assert ours.problem(PRESENT + 0.1) == ""
    assert ours.drivers(PRESENT + 0.1) == (PANDA.session,)


def test_a_driver_is_known_after_many_restarts():
    """In hours on end it may have had hundreds of addresses."""
    guard = watch()
    for k in range(300):
        now, address = 61.0 * k, f"c:{1000 + k}"
        identity = Identity(1000 + k, 50, "rt", "panda-driver")
        guard.hear(Packet(STATUS, b"", address), now)
        guard.hear(Packet(*report(identity, address)), now)
        guard.tidy(now)
        assert guard.drivers(now) == (identity.session,)


def test_a_shadow_minds_two_robots_only():
    shadow = watch((COMMAND, b"", THEIR), (STATUS, b"", ARM))
    assert shadow.problem(0.0, listens_only=True) == ""
    shadow.hear(Packet(STATUS, b"", ARM_2), 0.0)
    assert shadow.problem(0.0, listens_only=True)


def test_requests_are_for_one_session_fresh_and_whole():
    made, now = watch(), time.time()
    for data in (
        encode_request(THEM.session, "b"),
        b"nonsense",
        encode_request(US.session, "a")[:-1],
    ):
        made.hear(Packet(OPERATOR_REQUEST, data, THEIR), now)
    assert made.take_request() == ""
    assert made.broken
    made.hear(
        Packet(OPERATOR_REQUEST, encode_request(US.session, "a"), THEIR), now
    )
    assert (made.take_request(), made.take_request()) == ("a", "")
    made.hear(
        Packet(OPERATOR_REQUEST, encode_request(US.session, "a"), THEIR),
        now + 10.0,
    )
    assert made.take_request() == ""


@pytest.mark.parametrize(
    "channel", [COMMAND, STATUS, SESSION_LEASE, DRIVER_REPORT, OPERATOR_REQUEST]
)
def test_garbage_ends_nothing(channel):
    made = watch()
    for data in (b"", b"x", bytes(500), b"\xff" * 500):
        made.hear(Packet(channel, data, THEIR), 0.0)
    made.problem(0.0)
    made.tidy(100.0)


def until(done) -> None:
    end = time.monotonic() + 20.0
    while not done():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.skipif(
    not wire_works(), reason="this computer hears none of its own multicasts"
)
def test_the_second_controller_does_not_get_the_wire():
    config = HardwareConfig(lcm_url=free_url())
    driver, first, second = (config.open_lcm() for _ in range(3))
    guards = [
        WireGuard(lcm, config, name)
        for lcm, name in ((first, "first"), (second, "second"))
    ]

    def drives() -> None:
        driver.Publish(STATUS, b"")
        driver.Publish(DRIVER_REPORT, encode_report(Report(PANDA)))

    drives()
    assert guards[0].take_command(5.0) == ""
    first.Publish(COMMAND, b"")
    guards[1].listen()
    until(lambda: guards[1].listen() or guards[1].problem())
    refused = guards[1].take_command(0.0)
    assert refused.startswith(f"{COMMAND}: ") and "first" in refused
    # The other one has been left in peace.
    guards[0].listen()
    assert guards[0].problem() == ""
    operator = Operator(DrakeLcm(config.url))
    until(lambda: guards[0].listen() or operator.leases())
    leases = {a.identity.name: a for a in operator.listen_for(0.01)}
    assert leases["first"].drivers == (PANDA.session,)
    operator.arm(leases["first"].identity.session)
    until(lambda: guards[0].listen() or guards[0].take_request())
    guards[1].listen()
    assert guards[1].take_request() == ""
