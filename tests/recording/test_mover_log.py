"""Movers are recorded beside the ticks, and read back unchanged."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import FileError
from remosplat_drake.recording.metrics import run_metrics
from remosplat_drake.recording.mover_contacts import RESTING
from remosplat_drake.recording.trajectory import (
    Trajectory,
    load_trajectory,
    save_trajectory,
)
from remosplat_drake.scene.mover import Mover, Movers

DT = 0.1


def falling(time: float) -> Movers:
    """A ball that comes down on the arm, and a box beside it."""
    ball = Mover.sphere(
        "ball", [0.6, 0.0, 1.5 - time], 0.05, v_WM=[0, 0, -1], max_speed=2.0
    )
    X_WM = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [5, 5, 5])
    return Movers(time, [ball, Mover.box("box", X_WM, [0.1, 0.2, 0.3])])


def trajectory(robot, movers=falling) -> Trajectory:
    n = 8
    time = DT * np.arange(n)
    return Trajectory(
        time=time,
        q=np.zeros((n + 1, robot.n_q)),
        u=np.zeros((n, robot.n_u)),
        status=np.full(n, "optimal"),
        scale=np.ones(n),
        clearance=np.full(n, np.inf),
        timings={},
        movers=tuple(movers(t) for t in time) if movers else (),
    )


def test_they_are_read_as_they_were(lift_arm, tmp_path):
    kept = trajectory(lift_arm)
    save_trajectory(kept, tmp_path / "run.npz")
    read = load_trajectory(tmp_path / "run.npz")
    for a, b in zip(kept.movers, read.movers, strict=True):
        assert a.stamp == b.stamp
        assert [m.name for m in a] == [m.name for m in b]
        for x, y in zip(a.at(0.0), b.at(0.0), strict=True):
            np.testing.assert_allclose(x, y, atol=1e-12)


def test_a_run_without_any_is_as_before(lift_arm, tmp_path):
    save_trajectory(trajectory(lift_arm, None), tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as file:
        assert not any(name.startswith("mover_") for name in file)
    assert load_trajectory(tmp_path / "run.npz").movers == ()
    metrics = run_metrics(trajectory(lift_arm, None), lift_arm, DT, None)
    assert metrics.mover_distance_min is None and metrics.waited is None


@pytest.mark.parametrize("name", ["tick", "name", "state", "stamp"])
def test_what_does_not_fit_is_no_recording(lift_arm, tmp_path, name):
    save_trajectory(trajectory(lift_arm), tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as file:
        arrays = dict(file)
    arrays[f"mover_{name}"] = arrays[f"mover_{name}"][:-1]
    np.savez(tmp_path / "run.npz", **arrays)
    with pytest.raises(FileError, match="not a recorded trajectory"):
        load_trajectory(tmp_path / "run.npz")


def test_a_run_is_judged_by_them(lift_arm):
    metrics = run_metrics(trajectory(lift_arm), lift_arm, DT, None)
    (contact,) = (c for c in metrics.mover_contacts if c.link == "forearm")
    assert contact.kind == RESTING
    # Centres 0.16 m apart after a fall of 0.34 m.
    assert contact.start == pytest.approx(0.34, abs=1e-3)
    assert metrics.waited == pytest.approx(0.8)
    assert metrics.mover_distance_min is not None
    assert metrics.mover_distance_min < -0.1
    assert dc.asdict(metrics)["mover_contacts"][0]["mover"] == "ball"
