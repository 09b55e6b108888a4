"""Nothing that keeps its bound is touched by a link that moves towards it."""

import dataclasses as dc

import numpy as np
import pytest
from effort import effort
from programs import program_of
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    ConstantValueSource,
    ConstantVectorSource,
)
from wandering import EMPTY, RADIUS, make_law, wander_about

import remosplat_drake as rs
from remosplat_drake.controller.ingredients import (
    MoverDamper,
    MoverDamperConfig,
)
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals.binding import MOVER
from remosplat_drake.signals.distance_field import Clearances


@pytest.mark.parametrize("seed", range(effort(2, 6)))
def test_the_robot_touches_nothing(three_link, seed):
    wandered = wander_about(three_link, seed, 1500)
    assert wandered.towards == 0
    assert wandered.travelled > 0.5


def test_a_robot_that_sees_nothing_touches_it(three_link):
    """So the test above can fail."""
    blind = wander_about(three_link, 0, 1500, blind=True)
    assert blind.towards > 20


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 500))
def test_it_never_does(three_link, seed):
    """A million ticks, in 400 goes; `wandering.py` spreads them over cores."""
    assert wander_about(three_link, seed, 2500).towards == 0


def test_a_row_says_how_fast_a_mover_comes(three_link, make_tick):
    """Xi (d - d_s) / (d_i - d_s) - c, for each sphere that is near."""
    config = MoverDamperConfig(influence=0.8, separation=0.05, gain=1.5)
    q = np.array([0.3, -0.8, 0.2])
    state = three_link.state(q)
    ball = Mover.sphere(
        "Ada", state.spheres.p_WS[-1] + [0.5, 0, 0], RADIUS, v_WM=[-0.4, 0, 0]
    )
    tick = dc.replace(make_tick(three_link, q), movers=Movers(0.0, [ball]))
    near = tick.near_movers(0.8)
    rows = program_of(tick, [MoverDamper(config)]).terms.rows[MOVER]
    last = np.flatnonzero(near.sphere == len(state.spheres) - 1)[0]
    # A mover that accelerates by 5 m/s^2 for one and a half periods.
    grown = 0.5 * 5.0 * (1.5 * tick.dt) ** 2
    d = 0.5 - RADIUS - state.spheres.radius[-1] - grown
    assert rows.b[last] == pytest.approx(1.5 * (d - 0.05) / 0.75 - 0.4)
    np.testing.assert_allclose(rows.A[last], state.Jv_WS[-1][0], atol=1e-12)
    link = three_link.spheres.links[-1]
    assert rows.about(last) == (link, "Ada")


def test_without_movers_nothing_changes(three_link):
    law, q = make_law(three_link), np.array([0.3, -0.8, 0.2])
    X_WT = three_link.end_effector_pose(np.array([0.5, -0.5, 0.1]))

    def command(movers):
        return run_tick(
            law,
            0.0,
            q,
            X_WT,
            Clearances.none(),
            EMPTY,
            np.zeros(3),
            movers=movers,
        ).command

    far = Mover.sphere("far", [90.0, 0, 0], 0.1)
    for movers in (Movers(0.0), Movers(0.0, [far])):
        np.testing.assert_array_equal(command(None), command(movers))


def test_a_retreat_yields_first(three_link):
    """What comes faster than the arm can go leaves a program, and a reason."""
    law, q = make_law(three_link), np.array([0.3, -0.8, 0.2])
    hand = three_link.end_effector_pose(q)
    ball = Mover.sphere(
        "ball",
        hand[:3, 3] + [0.3, 0, 0],
        RADIUS,
        v_WM=[-30.0, 0, 0],
        max_speed=30.0,
    )
    report = run_tick(
        law,
        0.0,
        q,
        hand,
        Clearances.none(),
        EMPTY,
        np.zeros(3),
        movers=Movers(0.0, [ball]),
    )
    assert report.status == "relaxed"
    assert "mover[" in report.reason and "ball" in report.reason


def test_movers_come_by_a_port(three_link):
    law, q = make_law(three_link), np.array([0.3, -0.8, 0.2])
    hand = three_link.end_effector_pose(q)
    target = hand.copy()
    target[0, 3] += 0.1
    last = three_link.spheres_at(q)
    ahead = [last.radius[-1] + RADIUS + 0.02, 0, 0]
    ball = Mover.sphere("ball", last.p_WS[-1] + ahead, RADIUS)

    def advance(*movers) -> float:
        """The last sphere's speed towards the ball."""
        builder = DiagramBuilder()
        source = builder.AddSystem(ConstantVectorSource(q))
        oracle = rs.DistanceOracle.AddToBuilder(
            builder,
            robot=three_link,
            field=EMPTY,
            configuration=source.get_output_port(),
        )
        controller = rs.ReactiveController.AddToBuilder(
            builder,
            law=law,
            oracle=oracle,
            configuration=source.get_output_port(),
        )
        goal = builder.AddSystem(
            ConstantValueSource(Value(RigidTransform(target)))
        )
        builder.Connect(
            goal.get_output_port(), controller.GetInputPort("target")
        )
        for what in movers:
            said = builder.AddSystem(ConstantValueSource(Value[object](what)))
            builder.Connect(
                said.get_output_port(), controller.GetInputPort("movers")
            )
        simulator = Simulator(builder.Build())
        simulator.AdvanceTo(0.005)
        context = controller.GetMyContextFromRoot(simulator.get_context())
        report = controller.GetOutputPort("report").Eval(context)
        return three_link.state(q).Jv_WS[-1][0] @ report.command

    assert advance() > 0.01
    assert advance(Movers(0.0, [ball])) < 0.0
