"""The state of one tick, made from few arguments."""

import numpy as np
import pytest

from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances


@pytest.fixture(scope="session")
def make_tick():
    """A function (robot, q, ...) -> Tick; the default target is 0.1 m up."""

    def make(
        robot, q, *, X_WT=None, clearances=None, u_previous=None, dt=0.01
    ) -> Tick:
        state = robot.state(np.array(q, float))
        if X_WT is None:
            X_WT = state.X_WE.copy()
            X_WT[2, 3] += 0.1
        if clearances is None:
            clearances = Clearances.none()
        if u_previous is None:
            u_previous = np.zeros(robot.n_u)
        return Tick(
            robot=robot,
            state=state,
            aim=Aim.of(X_WT),
            clearances=clearances,
            u_previous=np.zeros(robot.n_u)
            if u_previous is None
            else u_previous,
            dt=dt,
        )

    return make
