"""Paths around standing movers, and waiting for passing ones."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.controller.guidance.present_state import PresentState
from remosplat_drake.controller.guidance.selection import (
    Selection,
    start_selection,
)
from remosplat_drake.controller.guidance.selection_round import (
    IDLE_AMONG_MOVERS,
    advance_selection,
)
from remosplat_drake.controller.guidance.standing_movers import (
    gone_mover,
    standing,
)
from remosplat_drake.controller.planning.obstructions import StandingMovers
from remosplat_drake.controller.program.guidance import DIRECT
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.near_movers import NearMovers

DT = 0.02
BLOCK = np.array([0.3, 0.5, 0.03])
AT = np.array([1.06, 0.0, 1.0])
"""Where the block of the maze is that can be passed with a bent elbow."""


def block(p_W=AT, v_W=(0.0, 0.0, 0.0)) -> Mover:
    X_WM = RigidTransform(np.array(p_W, float))
    bounds = {"max_speed": 1.0, "max_acceleration": 0.3}
    return Mover.box("Ada", X_WM, BLOCK, v_WM=np.array(v_W), **bounds)


@dc.dataclass
class Outcome:
    """How a run has gone: when it arrived, and what it did meanwhile."""

    arrived: float = np.inf
    guidances: set[str] = dc.field(default_factory=set)
    reasons: set[str] = dc.field(default_factory=set)
    nearest: float = np.inf


def drive(
    maze,
    empty,
    seen: Callable[[float], Mover | None],
    *,
    seconds: float = 15.0,
    looks_ahead: bool = True,
) -> Outcome:
    """Runs the closed loop among what moves, in a world without a scene."""
    rule, found = maze.rule(), Outcome()
    law, robot = rule.law.with_step(DT), maze.robot
    q, u, selection = maze.q, np.zeros(3), start_selection(rule)
    for k in range(round(seconds / DT)):
        mover = seen(k * DT)
        movers = Movers(k * DT, [mover] if mover else [])
        selection = advance_selection(
            rule,
            selection,
            time=k * DT,
            q=q,
            u=u,
            aim=maze.X_WT,
            field=empty,
            budget=200,
            movers=movers if looks_ahead else None,
        )
        found.guidances.add(selection.guidance.name)
        found.reasons.add(selection.reason)
        u = run_tick(
            law,
            k * DT,
            q,
            maze.X_WT,
            Clearances.none(),
            empty,
            u,
            selection.guidance,
            movers=movers,
        ).command
        q = robot.advance(q, u, DT)
        if mover:
            at_rest = StandingMovers.make(Movers(0.0, [mover]), 0.0).movers
            near = NearMovers.find(at_rest, 0.0, robot.spheres_at(q), np.inf)
            found.nearest = min(found.nearest, near.distance.min())
        X_WE = robot.end_effector_pose(q)
        if rule.arrived(pose_error(X_WE, maze.X_WT)):
            found.arrived = (k + 1) * DT
            break
    return found


def test_it_goes_round_what_stays(maze, empty):
    found = drive(maze, empty, lambda t: block())
    assert found.arrived < 12.0
    assert "plan" in found.guidances
    assert found.nearest > 0.0


def test_who_does_not_look_ahead_stands_before_it(maze, empty):
    """So the test above can fail."""
    found = drive(maze, empty, lambda t: block(), looks_ahead=False)
    assert found.arrived == np.inf


def test_it_waits_for_what_passes(maze, empty):
    """A plate crosses the arm's plane, and no path is searched for that."""

    def passing(t: float) -> Mover:
        x, y, z = AT
        plate = block((x, y + 0.8 * (t - 1.25), z), (0.0, 0.8, 0.0))
        return dc.replace(plate, half_extents=BLOCK * [1.0, 0.4, 1.0])

    alone = drive(maze, empty, lambda t: None)
    found = drive(maze, empty, passing)
    assert found.guidances == {"direct"}
    assert alone.arrived + 0.1 < found.arrived < 10.0
    assert found.nearest > 0.0


def test_a_way_that_becomes_free_is_taken(maze, empty):
    """What was gone round leaves: a path is not followed to its end."""

    def leaves(t: float) -> Mover | None:
        return block() if t < 1.0 else None

    found = drive(maze, empty, leaves)
    assert {"direct", "plan"} <= found.guidances
    assert "direct arrives" in found.reasons
    assert found.arrived < drive(maze, empty, lambda t: block()).arrived


def test_what_is_in_the_way_is_named_and_not_given_up(maze, empty):
    """It stands at the target itself: nothing leads there until it goes."""
    there = Mover.sphere("Bob", maze.X_WT[:3, 3], 0.15, max_acceleration=0.3)
    movers = Movers(0.0, [there])
    rule = maze.rule(attempts=1, seeds=8)
    selection = start_selection(rule)
    state = {"q": maze.q, "u": np.zeros(3), "aim": maze.X_WT, "field": empty}
    for k in range(40):
        selection = advance_selection(
            rule, selection, time=0.1 * k, budget=200, movers=movers, **state
        )
    assert selection.unreachable.startswith("Bob in the way: ")
    assert selection.failures == 1 and not selection.has_given_up(1)
    selection = advance_selection(
        rule, selection, time=4.0, budget=1000, movers=Movers(4.0), **state
    )
    assert selection.guidance.name == "direct"
    assert not selection.unreachable and not selection.is_hopeless
    assert selection.idle_until == pytest.approx(4.0 + IDLE_AMONG_MOVERS) or (
        selection.idle_until == 5.0
    )


def test_who_stands_and_who_has_gone():
    now = PresentState(1.0, np.zeros(3), np.zeros(3), Aim.of(np.eye(4)))
    assert not len(standing(now))
    slow = Mover.sphere("slow", [1, 0, 0], 0.1, v_WM=[0.05, 0, 0])
    fast = Mover.sphere("fast", [2, 0, 0], 0.1, v_WM=[0.5, 0, 0])
    seen = dc.replace(now, movers=Movers(0.0, [slow, fast]))
    (found,) = standing(seen)
    np.testing.assert_allclose(found.X_WM.translation(), [1.05, 0, 0])
    assert not found.v_WM.any()
    assert gone_mover(standing(seen), seen) == ""
    assert gone_mover(standing(seen), now) == "slow"
    far = Mover.sphere("slow", [1.3, 0, 0], 0.1)
    gone = dc.replace(now, movers=Movers(1.0, [fast, far]))
    assert gone_mover(standing(seen), gone) == "slow"
    assert gone_mover(Selection(DIRECT).around, gone) == ""
