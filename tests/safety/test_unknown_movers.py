"""A robot that no longer knows what moves around it is stopped."""

import numpy as np
import pytest
from pydrake.math import RigidTransform
from supervised import DT, VELOCITY, make_law, make_observation

from remosplat_drake.safety.supervisor import supervise
from remosplat_drake.scene.mover import Movers
from remosplat_drake.scene.mover_camera import MoverCamera
from remosplat_drake.signals.supervisor_state import (
    RUNNING,
    STARTING,
    STOPPED,
    STOPPING,
    SupervisorState,
)

LAW = make_law(max_movers_age=0.2)
NOW = 5.0
U = 0.5 * VELOCITY
RUNS = SupervisorState(U, mode=RUNNING, time=NOW - DT)


def tick(movers: Movers | None, state=RUNS, **seen) -> SupervisorState:
    now = make_observation(state, state.time + DT, U, movers=movers, **seen)
    return supervise(LAW, state, now)


def camera(seen: float, problem: str = "") -> MoverCamera:
    X_WC = RigidTransform()
    wide = np.ones(2)
    return MoverCamera("room", X_WC, -wide, wide, 0.3, 4, seen, problem)


@pytest.mark.parametrize(
    "movers",
    [
        None,
        Movers(NOW),
        Movers(NOW - 0.19),
        Movers(NOW + 0.19),
        # What is refused is named only where it has consequences.
        Movers(NOW - 0.1, problem="is not a whole mover_list"),
        Movers(NOW, cameras=[camera(NOW - 0.19, "it is dark")]),
    ],
)
def test_what_is_news_lets_it_go_on(movers):
    assert tick(movers).mode == RUNNING


@pytest.mark.parametrize(
    ("movers", "reason"),
    [
        (Movers(NOW - 0.3), "movers are not known: no newer state"),
        (Movers(NOW + 0.3), "movers are not known: no newer state"),
        (Movers(0.0, problem="MOVERS lies"), "movers are not known: MOVERS"),
        (
            Movers(NOW, cameras=[camera(NOW), camera(NOW - 0.5, "it is dark")]),
            "room has no usable image for 0.5 s: it is dark",
        ),
        (
            Movers(NOW, cameras=[camera(0.0)]),
            "no usable image for 5 s: no image",
        ),
    ],
)
def test_what_is_old_stops_it(movers, reason):
    state = tick(movers)
    assert state.mode == STOPPING
    assert reason in state.reason


def test_nothing_resumes_by_itself():
    state = tick(Movers(NOW - 1.0))
    for _ in range(200):
        state = tick(Movers(state.time + DT), state)
    assert state.mode == STOPPED
    np.testing.assert_array_equal(state.command, 0.0)
    old = Movers(state.time - 1.0)
    refused = tick(old, state, release=True)
    assert refused.mode == STOPPED
    assert "movers are not known" in refused.refusal
    news = Movers(state.time + DT)
    assert tick(news, state, release=True).mode == STARTING
