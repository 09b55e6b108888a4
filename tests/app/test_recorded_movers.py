"""The movers of an earlier run move again."""

from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.app.recorded_movers import RecordedMovers
from remosplat_drake.base.errors import FileError
from remosplat_drake.recording.mover_contacts import distances
from remosplat_drake.recording.trajectory import Trajectory, save_trajectory
from remosplat_drake.scene.mover import Mover, Movers

ROBOT = Path(__file__).resolve().parents[1] / "data" / "three_link.yaml"
DT = 0.1


@pytest.fixture
def folder(three_link, tmp_path) -> Path:
    """A run of three ticks, of an arm and a ball that passes."""
    q, u = [np.array([0.3, -0.8, 0.2])], np.array([0.5, -0.2, 0.1])
    for _ in range(3):
        q.append(three_link.advance(q[-1], u, DT))
    times = 5.0 + DT * np.arange(3)
    save_trajectory(
        Trajectory(
            time=times,
            q=np.array(q),
            u=np.tile(u, (3, 1)),
            status=np.full(3, "optimal"),
            scale=np.ones(3),
            clearance=np.full(3, np.inf),
            timings={},
            movers=tuple(
                Movers(
                    t, [Mover.sphere("ball", [t, 0, 0], 0.1, v_WM=[1, 0, 0])]
                )
                for t in times
            ),
        ),
        tmp_path / "trajectory.npz",
    )
    return tmp_path


@pytest.mark.parametrize(
    ("time", "x", "v"),
    [(0.0, 5.0, 1.0), (0.13, 5.13, 1.0), (0.2, 5.2, 0.0), (9.0, 5.2, 0.0)],
)
def test_what_moved_moves_again(folder, time, x, v):
    (ball,) = RecordedMovers().make(folder).movers(time)
    np.testing.assert_allclose(ball.X_WM.translation(), [x, 0, 0], atol=1e-9)
    assert ball.v_WM[0] == v


@pytest.mark.parametrize("time", [0.0, 0.07, 0.15, 5.0])
def test_the_robot_itself_may_be_what_moves(folder, three_link, time):
    track = RecordedMovers(robot=str(ROBOT)).make(folder)
    movers = track.movers(time)
    q = three_link.advance(
        np.array([0.3, -0.8, 0.2]), np.array([0.5, -0.2, 0.1]), min(time, 0.3)
    )
    spheres = three_link.spheres_at(q)
    gap, _ = distances(
        Movers(0.0, movers).at(0.0), spheres.p_WS, spheres.radius
    )
    assert (gap.min(axis=0) < 0.0).all()
    assert any(m.v_WM.any() for m in movers) == (time < 0.2)


def test_a_run_in_which_nothing_moved_is_named(folder, three_link):
    bare = RecordedMovers(robot=str(ROBOT)).make(folder)
    assert bare.movers(0.0)
    with np.load(folder / "trajectory.npz") as file:
        arrays = {k: v for k, v in file.items() if not k.startswith("mover_")}
    np.savez(folder / "trajectory.npz", **arrays)
    with pytest.raises(FileError, match="contains no movers"):
        RecordedMovers().make(folder)


def test_another_robots_run_is_named(folder):
    with pytest.raises(FileError, match="of 3 positions, but"):
        RecordedMovers(robot="frankie").make(folder)
