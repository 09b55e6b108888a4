"""A trial: a problem by family and seed, and its outcome."""

import dataclasses as dc
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from apps.studies.pick_and_place.problem_run import (
    UNSOLVABLE,
    Outcome,
    run_problem,
)
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.generation.object_library import read_mesh_library
from remosplat_drake.generation.pick_and_place import FAMILIES, pick_and_place
from remosplat_drake.grasping.gripper import ParallelGripper
from remosplat_drake.robot.robot_model import load_robot

NOT_BUILT, CRASHED = "not built", "crashed"
"""Causes of problems that were not run, or not completed."""

DRAWS = 20
"""Largest number of draws until a problem has a solution."""

_NEXT = 1_000_000  # Difference of the seeds of two draws.


@dc.dataclass(frozen=True)
class Trial:
    """A problem that is drawn from a seed.

    Attributes:
        family: Family of the problem.
        seed: Its seed.
        library: Folder of meshes for half of the objects; None for none.
    """

    family: str
    seed: int
    library: Path | None = None

    @property
    def key(self) -> str:
        """Name of the problem."""
        return f"{self.family}-{self.seed:04d}"


def run_trial(trial: Trial) -> Outcome:
    """Draws a problem and runs it.

    A problem is drawn again if it has no solution, that is, no grasp for which
    the hand is wide and strong enough and which the arm reaches at both places.

    Args:
        trial: The trial.
    """
    gripper = _gripper(FAMILIES[trial.family][0])
    outcome = Outcome(trial.key, "", 0.0, NOT_BUILT)
    for draw in range(DRAWS):
        seed = trial.seed + draw * _NEXT
        try:
            problem = pick_and_place(
                trial.family, seed, gripper, _hulls(trial.library)
            )
            outcome = run_problem(problem, gripper)
        except RemoSplatError as error:
            outcome = Outcome(trial.key, "", 0.0, NOT_BUILT, str(error))
        outcome = dc.replace(outcome, key=trial.key, draws=draw + 1)
        if outcome.cause not in (*UNSOLVABLE, NOT_BUILT):
            break
    return outcome


def failed(trial: Trial, error: str) -> Outcome:
    """Makes the outcome of a trial that crashed; it is tried again.

    Args:
        trial: The trial.
        error: Text of the error.
    """
    return Outcome(trial.key, "", 0.0, CRASHED, error=error)


def restored(fields: dict[str, Any]) -> Outcome:
    """Restores an outcome from the fields of a file's line."""
    return Outcome(**fields)


@lru_cache
def _gripper(robot: str) -> ParallelGripper:
    return ParallelGripper.of(load_robot(robot))


@lru_cache
def _hulls(library: Path | None) -> list[np.ndarray]:
    if library is None:
        return []
    return list(read_mesh_library(library).hulls.values())
