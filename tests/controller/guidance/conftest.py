"""A small arm over a slab: targets that some stopping distances reach."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.guidance import selection_round
from remosplat_drake.controller.guidance.planner import Situation
from remosplat_drake.controller.guidance.selection_rule import SelectionRule
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene


@dc.dataclass(frozen=True)
class Fixed:
    """Proposes the same candidates every time."""

    tiers: tuple[tuple[Guidance, ...], ...]

    def propose(self, situation: Situation) -> tuple[tuple[Guidance, ...], ...]:
        return self.tiers


@dc.dataclass(frozen=True)
class ToyWorld:
    """The three-link arm, a slab under it, and a target 15 mm above that.

    Attributes:
        law: The law of rollouts, with a step of 0.1 s.
        field: The slab. At the target, the nearest sphere is 15 mm above it.
        q: Where the arm starts.
        X_WT: The target, reached at configuration `q_target`.
        q_target: See `X_WT`.
        far: A guidance that keeps too far away to reach the target.
        near: One that does not.
    """

    law: ReactiveLaw
    field: SignedDistanceField
    q: np.ndarray
    X_WT: np.ndarray
    q_target: np.ndarray
    far: Guidance
    near: Guidance

    def rule(self, *tiers: tuple[Guidance, ...]) -> SelectionRule:
        """A rule with these candidates that asks for 3 mm."""
        start = tiers[0][0] if tiers else Guidance()
        return SelectionRule(
            self.law,
            Fixed(tiers),
            (start.stopping or 0.0,),
            lambda error: error.distance < 0.003,
            4.0,
            start,
        )


@pytest.fixture(scope="session")
def toy(three_link) -> ToyWorld:
    q_target = np.array([0.3, 0.2, 0.0])
    spheres = three_link.spheres_at(q_target)
    lowest = (spheres.p_WS[:, 2] - spheres.radius).min()
    slab = Box(
        RigidTransform([0.5, 0, lowest - 0.015 - 0.1]), np.array([1, 1, 0.1])
    )
    return ToyWorld(
        ReactiveLaw.make(gain_set("tuned"), three_link, 0.1),
        SignedDistanceField(PrimitiveScene(boxes=(slab,))),
        np.array([0.1, 0.0, 0.0]),
        three_link.end_effector_pose(q_target),
        q_target,
        far=Guidance("far", stopping=0.030),
        near=Guidance("near", stopping=0.005),
    )


@pytest.fixture
def counted(monkeypatch) -> list[Guidance]:
    """The guidance of every rollout step that the selection takes."""
    taken: list[Guidance] = []
    advance: Callable = selection_round.advance_rollout

    def counting(law, rollout, *arguments):
        after = advance(law, rollout, *arguments)
        taken.extend([rollout.guidance] * (after.num_steps - rollout.num_steps))
        return after

    monkeypatch.setattr(selection_round, "advance_rollout", counting)
    return taken
