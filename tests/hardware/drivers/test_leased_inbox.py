"""The session that a driver follows, by its lease and its address."""

import dataclasses as dc
import time

import pytest
from pydrake.lcm import DrakeLcm

from remosplat_drake.acceptance.hardware_processes import free_url, wire_works
from remosplat_drake.hardware.drivers.leased_inbox import Hold, LeasedInbox
from remosplat_drake.hardware.wire.channels import PANDA_COMMAND
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.lease import (
    DRIVER_REPORT,
    SESSION_LEASE,
    Identity,
    Lease,
    Report,
    decode_report,
    encode_lease,
)

DRIVER = 5
OURS = Lease(Identity(1, 10, "lab", "ours"), drivers=(DRIVER,))
THEIRS = Lease(Identity(2, 20, "lab", "theirs"), drivers=(DRIVER,))
A, B = "10.0.0.1:1", "10.0.0.2:2"


def held(*events: tuple[Lease, str, float]) -> Hold:
    hold = Hold()
    for lease, sender, now in events:
        hold = hold.after_lease(lease, sender, DRIVER, now)
    return hold


def test_no_session_is_obeyed_without_a_lease():
    assert not Hold().admits(A, 0.0)
    assert not Hold().admits("", 0.0)


def test_the_first_session_is_obeyed_and_no_other():
    hold = held((OURS, A, 0.0), (THEIRS, B, 0.1))
    assert hold.admits(A, 0.2) and not hold.admits(B, 0.2)


def test_a_lease_that_names_another_driver_counts_for_nothing():
    elsewhere = dc.replace(OURS, drivers=(6, 7))
    assert not held((elsewhere, A, 0.0)).admits(A, 0.0)


def test_a_session_that_gives_up_the_driver_is_obeyed_no_more():
    hold = held((OURS, A, 0.0), (dc.replace(OURS, drivers=()), A, 0.1))
    assert not hold.admits(A, 0.1)
    assert hold.after_lease(THEIRS, B, DRIVER, 0.2).admits(B, 0.2)


def test_silence_ends_a_lease_and_commands_keep_it():
    hold = held((OURS, A, 0.0))
    assert hold.admits(A, 1.0) and not hold.admits(A, 1.01)
    kept = hold.after_command(A, 0.9)
    assert kept.admits(A, 1.8)
    assert not hold.after_command(B, 0.9).admits(A, 1.8)
    late = hold.after_lease(THEIRS, B, DRIVER, 1.1)
    assert late.admits(B, 1.1) and not late.admits(A, 1.1)


def test_a_session_may_come_from_another_address():
    hold = held((OURS, A, 0.0), (OURS, B, 0.1))
    assert hold.admits(B, 0.1) and not hold.admits(A, 0.1)


@pytest.mark.skipif(
    not wire_works(), reason="this computer hears none of its own multicasts"
)
def test_on_a_wire_strangers_are_refused_counted_and_reported():
    url, news = free_url(), []
    lcm = DrakeLcm(url)
    inbox = LeasedInbox(
        lcm,
        [PANDA_COMMAND],
        name="driver",
        open_channels=["FREE"],
        on_news=news.append,
    )
    reports = Inbox(DrakeLcm(url), [DRIVER_REPORT])
    ours, stranger = DrakeLcm(url), DrakeLcm(url)
    lease = dc.replace(OURS, drivers=(inbox.identity.session,))
    ours.Publish(SESSION_LEASE, encode_lease(lease))
    stranger.Publish(SESSION_LEASE, b"nonsense")
    time.sleep(0.05)
    for sender, data in ((ours, b"1"), (stranger, b"2"), (ours, b"3")):
        sender.Publish(PANDA_COMMAND, data)
        time.sleep(0.01)
    stranger.Publish("FREE", b"4")
    heard = []
    end = time.monotonic() + 10.0
    while len(heard) < 3 and time.monotonic() < end:
        heard += inbox.fetch(0.01)
    assert heard == [
        (PANDA_COMMAND, b"1"),
        (PANDA_COMMAND, b"3"),
        ("FREE", b"4"),
    ]
    assert news[0].startswith("follows ours, pid 10 on lab, at ")
    # Once a stranger, however much it says.
    assert [line.split(" from ")[0] for line in news[1:]] == [
        f"refuses {SESSION_LEASE}"
    ]
    report = Report(inbox.identity)
    while report.refused < 2 and time.monotonic() < end:
        inbox.fetch()
        for _, data in reports.fetch(0.02):
            report = decode_report(data)
    assert (report.holder, report.obeyed) == (OURS.identity.session, 3)
    assert report.refused == 2 and report.refused_from
