"""Memory of a process, and its growth."""

import mmap
import os

import pytest

from apps.studies.live_map.memory_use import MemoryUse, memory_of, trend


def test_what_is_taken_shows():
    before = memory_of()
    # An array could lie in memory that the heap has left from before.
    flags = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS
    with mmap.mmap(-1, 64 << 20, flags) as taken:
        taken[::4096] = bytes(len(taken) // 4096)
        assert memory_of(os.getpid()).own - before.own > 50


def test_mapped_files_are_told_apart(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(bytes(40 << 20))
    before = memory_of()
    with (
        path.open("rb") as file,
        mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_COPY) as data,
    ):
        sum(data[::4096])
        after = memory_of()
    assert after.files - before.files > 30
    assert after.own - before.own < 10


def test_what_happens_first_does_not_count():
    minutes = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    uses = [MemoryUse(100 * min(t, 2) + 3 * t, 10 * t) for t in minutes]
    measured = trend(minutes, uses)
    assert measured.own_slope == pytest.approx(3)
    assert measured.slope == pytest.approx(13)
    assert measured.first == pytest.approx(226)
    assert measured.last == measured.most == pytest.approx(278)
