"""An arm that reaches to and fro while things come for its hand.

To see it for a million ticks, on all cores:

    python -m tests.controller.wandering --seeds 100:500 --ticks 2500
"""

import argparse
import dataclasses as dc
import os
from collections import deque
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from scipy.spatial.transform import Rotation

from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.distance_field import Clearances

DT = 0.01
RADIUS = 0.1
FASTEST, MOST = 1.0, 3.0
EMPTY = SignedDistanceField(PrimitiveScene())
ROBOT = Path(__file__).parents[1] / "data" / "three_link.yaml"

LATEST = 5
"""By how many ticks what is seen of a mover may be late."""

_WITHIN = 0.98
"""By how much motions keep within their bounds: they are made of steps."""

_BENT = 1e-5
"""A retreat is checked from sample to sample, and may bend by so much [m]."""


def make_law(robot: RobotModel) -> ReactiveLaw:
    config = gain_set("tuned")
    config.solver, config.guidance.enabled = "active_set", False
    return ReactiveLaw.make(config, robot, DT)


class Wanderer:
    """A capsule that moves and turns as it likes, within its bounds.

    It comes for something, and is seen late and wrongly: by no more than it is
    said to be.

    Args:
        rng: Source of its whims.
        p_W: Where it begins [m].
        half_length: Half the length of its axis; 0 makes it a ball [m].
        late: By how many ticks it is seen late.
        error: By how much its position is seen wrongly [m].
    """

    def __init__(
        self,
        rng: np.random.Generator,
        p_W,
        half_length: float = 0.0,
        late: int = 0,
        error: float = 0.0,
    ):
        self._rng, self._error = rng, error
        self.half_length = half_length
        self.p_W, self.v_W = np.array(p_W, float), np.zeros(3)
        self.R_W, self.w_W = Rotation.random(rng=rng), np.zeros(3)
        self._seen: deque[Mover] = deque(maxlen=late + 1)
        self._look()

    def wander(self, goal_W: np.ndarray) -> None:
        """Goes on for a tick: towards something, and anywhere."""
        share = 0.5 if self.half_length else 1.0
        push = goal_W - self.p_W + self._rng.normal(size=3) * 0.5
        v = self.v_W + share * MOST * DT * push / np.linalg.norm(push)
        v = _shorten(v, share * FASTEST)
        # Half-way, so that what it did is within its bounds all the time.
        self.p_W = self.p_W + 0.5 * (self.v_W + v) * DT
        self.v_W = v
        if self.half_length:
            self._turn()
        self._look()

    def _turn(self) -> None:
        """Turns: by a quarter of its bounds faster, by a quarter all along."""
        fastest = min(
            0.5 * FASTEST / self.half_length,
            np.sqrt(0.25 * MOST / self.half_length),
        )
        spin = _shorten(self._rng.normal(size=3), 0.25 * MOST)
        w = self.w_W + _WITHIN * spin * DT / self.half_length
        w = _shorten(w, _WITHIN * fastest)
        mean = 0.5 * (self.w_W + w)
        self.R_W = Rotation.from_rotvec(mean * DT) * self.R_W
        self.w_W = w

    def _look(self) -> None:
        wrong = _shorten(self._rng.normal(size=3), self._error)
        self._seen.append(
            Mover.capsule(
                "it",
                RigidTransform(
                    RotationMatrix(self.R_W.as_matrix()), self.p_W + wrong
                ),
                self.half_length,
                RADIUS,
                v_WM=self.v_W,
                w_WM=self.w_W,
                max_speed=FASTEST,
                max_acceleration=MOST,
                position_error=self._error,
            )
        )

    @property
    def seen(self) -> Mover:
        """What is known of it: how it was some ticks ago."""
        return self._seen[0]

    @property
    def late(self) -> int:
        """How many ticks ago that was."""
        return len(self._seen) - 1

    def gaps(self, p_WS: np.ndarray) -> np.ndarray:
        """From points to the nearest of its axis, shape (n, 3) [m]."""
        axis = self.R_W.as_matrix()[:, 2]
        along = np.clip(
            (p_WS - self.p_W) @ axis, -self.half_length, self.half_length
        )
        return self.p_W + along[:, None] * axis - p_WS


def _shorten(vector: np.ndarray, longest: float) -> np.ndarray:
    length = np.linalg.norm(vector)
    return vector * (longest / length) if length > longest else vector


@dc.dataclass
class Outcome:
    """Ticks after which a sphere was touched, by what it did itself."""

    towards: int = 0
    otherwise: int = 0
    travelled: float = 0.0

    def __add__(self, other: "Outcome") -> "Outcome":
        return Outcome(
            self.towards + other.towards,
            self.otherwise + other.otherwise,
            self.travelled + other.travelled,
        )


def wander_about(
    robot: RobotModel, seed: int, ticks: int, *, blind: bool = False
) -> Outcome:
    """Lets the arm reach to and fro while one to three things come for it."""
    rng, law, found = np.random.default_rng(seed), make_law(robot), Outcome()
    q, u = np.array([0.3, -0.8, 0.2]), np.zeros(robot.n_u)
    late, crowd = int(rng.integers(LATEST + 1)), []
    for k in range(rng.integers(1, 4)):
        length = rng.choice([0.0, rng.uniform(0.05, 0.3)])
        begin = [1.5 + k, 0.5 * k, 0.5]
        error = rng.choice([0.0, 0.02])
        crowd.append(Wanderer(rng, begin, length, late, error))
    X_WT = robot.end_effector_pose(q)
    for k in range(ticks):
        if k % 100 == 0:
            X_WT = robot.end_effector_pose(rng.uniform(-1.0, 1.0, 3))
        stamp = (k - crowd[0].late) * DT
        movers = Movers(stamp, [one.seen for one in crowd])
        report = run_tick(
            law,
            k * DT,
            q,
            X_WT,
            Clearances.none(),
            EMPTY,
            u,
            movers=None if blind else movers,
        )
        before = robot.spheres_at(q)
        u = report.command
        q = robot.advance(q, u, DT)
        p_WE = robot.end_effector_pose(q)[:3, 3]
        after = robot.spheres_at(q)
        moved = after.p_WS - before.p_WS
        for one in crowd:
            one.wander(p_WE)
            gap = one.gaps(after.p_WS)
            apart = np.linalg.norm(gap, axis=1)
            touched = apart < after.radius + RADIUS
            ahead = np.einsum("ni,ni->n", gap, moved) / apart
            found.towards += int((touched & (ahead > _BENT)).sum())
            found.otherwise += int((touched & (ahead <= _BENT)).sum())
        found.travelled += float(np.linalg.norm(moved[-1]))
    return found


def _go(seed: int, ticks: int) -> tuple[int, Outcome]:
    return seed, wander_about(load_robot(ROBOT), seed, ticks)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="100:500", help="first:end")
    parser.add_argument("--ticks", type=int, default=2500, help="of each seed")
    parser.add_argument("--cores", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    first, end = map(int, arguments.seeds.split(":"))
    _go(first, 20)  # What is compiled here is there for all.
    total, ticks = Outcome(), 0
    with ProcessPoolExecutor(arguments.cores) as pool:
        go = partial(_go, ticks=arguments.ticks)
        for seed, found in pool.map(go, range(first, end)):
            total, ticks = total + found, ticks + arguments.ticks
            if found.towards or not (seed + 1 - first) % 20:
                print(f"seed {seed}: {found}; all {ticks} ticks: {total}")
    print(f"{ticks} ticks: {total}")


if __name__ == "__main__":
    main()
