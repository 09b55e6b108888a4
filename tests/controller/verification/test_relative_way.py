"""No point of a link moves farther, as another sees it, than its bounds."""

import numpy as np
import pytest

from remosplat_drake.controller.verification.kernels.relative_way import (
    relative_bend,
    relative_way,
)
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.robot.robot_model import load_robot


@pytest.mark.parametrize("name", ["frankie", "panda"])
def test_ways_and_rates_are_bounds(name):
    robot = load_robot(name)
    own = SelfClearance.make(robot, 0.01)
    pairs, shapes = own.pairs.pairs, own.pairs.shapes
    body, rng = pairs.shapes.body, np.random.default_rng(5)
    arm = np.isfinite(robot.position_lower)
    lower = np.where(arm, robot.position_lower, -3.0)
    upper = np.where(arm, robot.position_upper, 3.0)
    tightest = np.inf
    for _ in range(150):
        q, time = rng.uniform(lower, upper), rng.uniform(0.01, 0.4)
        u = rng.uniform(-1, 1, robot.n_u) * robot.velocity_limit
        u *= rng.random(robot.n_u) < 0.6
        link = rng.integers(len(pairs.links))
        k = rng.integers(pairs.start[link], pairs.start[link + 1])
        i, j = pairs.first[k], pairs.second[k]
        X = [
            robot.body_poses(robot.advance(q, u, t))
            for t in np.linspace(0.0, time, 101)
        ]
        p_L = shapes.shapes[j].vertices
        seen = []
        for x in X:
            X_AB = np.linalg.inv(x[body[i]]) @ x[body[j]]
            seen.append(p_L @ X_AB[:3, :3].T + X_AB[:3, 3])
        steps = np.linalg.norm(np.diff(seen, axis=0), axis=2)
        # Any point may be the one that counts, another at each time.
        way = steps.max(axis=1).sum()
        center, reach = shapes.center[j], shapes.reach[j]
        bend = relative_bend(
            own.lever[link],
            robot.screw_turns,
            np.abs(u),
            np.linalg.norm(center),
            reach,
        )
        place = body[i], body[j], center, reach
        bound = relative_way(X[0], X[-1], *place, bend, time)
        assert way <= bound + 1e-12
        assert way <= own.rate[link] @ np.abs(u) * time + 1e-12
        if way > 1e-3:
            tightest = min(tightest, bound / way)
    assert tightest < 1.3


def test_what_carries_both_links_around_moves_neither(frankie):
    own = SelfClearance.make(frankie, 0.01)
    # The base drives and turns, and the first joint turns the whole arm.
    for (a, b), rate in zip(own.pairs.pairs.links, own.rate, strict=True):
        assert (rate[:2] == 0.0).all()
        assert (rate[2] > 0.0) == (a in ("base_link", "panda_link0")), (a, b)
