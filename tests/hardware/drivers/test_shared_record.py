"""Records cross between processes whole, or not at all."""

import multiprocessing
import struct

from effort import effort

from remosplat_drake.hardware.drivers.shared_record import SharedRecord

SIZE = 60


def write_on(record: SharedRecord, ready, over) -> None:
    """Writes records of one number each, which grows, without a pause."""
    number = 0.0
    while not over.is_set():
        for _ in range(200):
            number += 1.0
            record.write((number,) * SIZE)
        ready.set()
    record.close()


def test_a_record_is_never_torn_and_never_goes_back():
    spawn = multiprocessing.get_context("spawn")
    ready, over = spawn.Event(), spawn.Event()
    record = SharedRecord(SIZE)
    writer = spawn.Process(target=write_on, args=(record, ready, over))
    writer.start()
    try:
        assert ready.wait(60)
        latest, seen = 0.0, set()
        while len(seen) < effort(50, 500):
            values = record.read()
            assert len(set(values)) == 1
            assert values[0] >= latest
            latest = values[0]
            seen.add(latest)
    finally:
        over.set()
        writer.join()
        record.close()


def test_half_a_record_is_not_read():
    record = SharedRecord(2)
    record.write((1.0, 1.0))
    assert record.read() == (1.0, 1.0)
    # What a writer that is stopped half-way leaves behind.
    record._count[0] += 1
    struct.pack_into("d", record._bytes, 8, 2.0)
    assert record.read() == (1.0, 1.0)
    record._count[0] += 1
    assert record.read() == (2.0, 1.0)
    record.close()


def test_a_reader_that_came_late_has_zeros():
    record = SharedRecord(2)
    record._count[0] += 1
    assert record.read() == (0.0, 0.0)
    record.close()
