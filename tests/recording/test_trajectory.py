"""Trajectories: saved whole or not at all."""

import contextlib
import dataclasses as dc
import tracemalloc
import zipfile

import numpy as np
import pytest

from remosplat_drake.base.errors import FileError
from remosplat_drake.recording import trajectory as module
from remosplat_drake.recording.tick_table import TickTable
from remosplat_drake.recording.trajectory import (
    Trajectory,
    load_trajectory,
    save_trajectory,
)


@pytest.fixture
def trajectory() -> Trajectory:
    return Trajectory(
        time=np.array([0.0, 0.1, 0.2]),
        q=np.arange(12.0).reshape(4, 3),
        u=np.arange(6.0).reshape(3, 2),
        status=np.array(["optimal", "acceleration_dropped", "optimal"]),
        scale=np.array([1.0, 0.5, 0.25]),
        clearance=np.array([0.5, 0.4, np.inf]),
        timings={"solve": np.array([0.0, 1e-3, np.nan])},
    )


@pytest.fixture
def empty() -> Trajectory:
    return TickTable(3, 2).trajectory(np.zeros(3))


def assert_equal(a: Trajectory, b: Trajectory) -> None:
    for field in dc.fields(Trajectory):
        x, y = getattr(a, field.name), getattr(b, field.name)
        if field.name == "timings":
            assert x.keys() == y.keys()
            for phase in x:
                np.testing.assert_array_equal(x[phase], y[phase])
        elif field.name == "movers":
            assert x == y
        else:
            np.testing.assert_array_equal(x, y)
            assert x.dtype == y.dtype


def test_a_saved_trajectory_is_loaded_again(trajectory, empty, tmp_path):
    path = tmp_path / "deep" / "trajectory.npz"
    save_trajectory(trajectory, path)
    assert_equal(load_trajectory(path), trajectory)
    save_trajectory(empty, path)
    assert_equal(load_trajectory(path), empty)


def test_a_failed_save_leaves_the_old_file(
    trajectory, empty, tmp_path, monkeypatch
):
    path = tmp_path / "trajectory.npz"
    save_trajectory(trajectory, path)

    def fail_half_way(file, **arrays):
        file.write(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(module.np, "savez_compressed", fail_half_way)
    with pytest.raises((OSError, FileError)):
        save_trajectory(empty, path)
    monkeypatch.undo()
    assert_equal(load_trajectory(path), trajectory)
    assert [p.name for p in tmp_path.iterdir()] == ["trajectory.npz"]


@pytest.mark.parametrize(
    ("name", "array"),
    [
        ("time", np.zeros((2, 2))),
        ("q", np.zeros((1, 3))),
        ("u", np.zeros(3)),
        ("status", np.zeros(3)),
        ("scale", np.array(["a", "b", "c"])),
        ("timing_total", np.zeros(9)),
    ],
)
def test_arrays_that_do_not_fit_are_refused(trajectory, tmp_path, name, array):
    path = tmp_path / "trajectory.npz"
    save_trajectory(trajectory, path)
    with np.load(path) as archive:
        arrays = dict(archive) | {name: array}
    np.savez(path, **arrays)
    with pytest.raises(FileError, match="is not a recorded trajectory"):
        load_trajectory(path)


@pytest.mark.parametrize("content", [None, b"", b"nonsense", b"PK\x05\x06"])
def test_what_is_no_trajectory_is_an_error_of_the_user(tmp_path, content):
    path = tmp_path / "trajectory.npz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(FileError, match=r"trajectory\.npz"):
        load_trajectory(path)


def npz(path, **members):
    """An archive like NumPy's, of any bytes, with sums that fit them."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)


def npy(header: str, content: bytes = b"") -> bytes:
    line = header.encode() + b"\n"
    size = len(line).to_bytes(2, "little")
    return b"\x93NUMPY\x01\x00" + size + line + content


@pytest.mark.parametrize(
    "content",
    [
        b"",
        npy("{"),
        npy("{'descr': '<f8', 'fortran_order': False"),
        npy("{'descr': '<f8', 'fortran_order': False, 'shape': (-1,)}"),
        npy("{'descr': '<f8', 'fortran_order': False, 'shape': (10**9,)}"),
        npy("{'descr': '<f8', 'fortran_order': False, 'shape': (10000000,)}"),
        npy("{'descr': '|O', 'fortran_order': False, 'shape': (1,)}", b"." * 8),
        b"\x93NUMPY\x09\x00",
        bytes(10**8),
    ],
)
def test_damaged_arrays_take_no_memory(trajectory, tmp_path, content):
    path = tmp_path / "trajectory.npz"
    npz(path, time=content)
    tracemalloc.start()
    try:
        with pytest.raises(FileError, match=r"trajectory\.npz"):
            load_trajectory(path)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 10**7


def test_damaged_packing_is_an_error_of_the_user(trajectory, tmp_path):
    path = tmp_path / "trajectory.npz"
    save_trajectory(trajectory, path)
    data = path.read_bytes()
    for start in range(30, len(data) - 40, 37):
        path.write_bytes(data[:start] + b"\xff" * 8 + data[start + 8 :])
        with contextlib.suppress(FileError):  # What is no harm may be read.
            load_trajectory(path)


@pytest.mark.parametrize(
    "change",
    [
        {"q": np.zeros((2, 3))},
        {"u": np.zeros(3)},
        {"time": np.array(1.0)},
        {"time": np.array(["1", "2", "3"])},
        {"status": np.zeros(3)},
        {"scale": np.zeros((3, 3, 3))},
    ],
)
def test_arrays_that_do_not_fit_each_other(trajectory, tmp_path, change):
    path = tmp_path / "trajectory.npz"
    save_trajectory(dc.replace(trajectory, **change), path)
    with pytest.raises(FileError, match=r"trajectory\.npz"):
        load_trajectory(path)


def test_an_archive_of_other_arrays_is_no_trajectory(tmp_path):
    path = tmp_path / "other.npz"
    np.savez(path, other=np.zeros(3))
    with pytest.raises(FileError, match="not a recorded trajectory"):
        load_trajectory(path)
