"""Targets of the study of causes and offers, and what it counts."""

import dataclasses as dc

import numpy as np
import pytest

from apps.studies import offers as study
from apps.studies.offers import (
    ABOVE,
    IN_FLOOR,
    IN_SOLID,
    KINDS,
    Outcome,
    Trial,
    draw_target,
    restored,
    run_trial,
    table_of,
)
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.cockpit.offers import NEARER
from remosplat_drake.robot.sphere_model import Spheres


@pytest.fixture(scope="module")
def world():
    return load_world(load_scenario(study.SCENARIO))


def test_targets_are_of_their_kinds(world):
    for seed in range(30):
        trial = Trial(seed)
        p_W = draw_target(trial, world)[:3, 3]
        clearance = world.field.clearances(Spheres.at(p_W), 5.0).minimum()
        if trial.kind == IN_SOLID:
            assert clearance < 0
        elif trial.kind == IN_FLOOR:
            assert p_W[2] <= 0
        else:
            assert p_W[2] > 2 and clearance > 0.5
        np.testing.assert_array_equal(p_W, draw_target(trial, world)[:3, 3])


def test_the_table_counts():
    right = Outcome("0", IN_SOLID, "blocked", 0.1, "held", 0.5, True)
    outcomes = [
        dc.replace(right, offers=("Higher",), works=True),
        dc.replace(right, offers=("Higher",), delay=0.7),
        dc.replace(right, told="", delay=float("nan"), is_right=False),
    ]
    (row,) = table_of(outcomes).rows
    assert row == (IN_SOLID, "2 of 3", "0.70", "100", "1 of 2")
    assert restored(dc.asdict(outcomes[0])) == outcomes[0]


@pytest.mark.slow
@pytest.mark.parametrize("kind", [IN_FLOOR, ABOVE])
def test_a_cause_is_told_and_an_offer_works(kind):
    outcome = run_trial(Trial(KINDS.index(kind)))
    assert outcome.is_right and outcome.works
    if kind == ABOVE:
        assert NEARER in outcome.offers
