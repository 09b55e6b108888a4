"""Finds the seeds of generated scenes that pass the feasibility filter.

Results of the filter are stored in a file, since the search for a configuration
at an unreachable goal takes seconds.
"""

import dataclasses as dc
import hashlib
import json
from collections.abc import Callable
from contextlib import closing
from functools import lru_cache
from itertools import count as count_from
from pathlib import Path

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.pool import run_all
from remosplat_drake.base.strict_json import parse_json
from remosplat_drake.generation.feasibility import (
    FILTER_VERSION,
    FeasibilityFilter,
    passes,
)
from remosplat_drake.generation.scene_generators import (
    GENERATOR_VERSION,
    generate,
)
from remosplat_drake.robot.robot_model import RobotModel, load_robot

ROBOT = "frankie"
"""Robot that must reach the goals."""

FLOOR_HEIGHT = 0.03
"""Links that are close to the floor ignore the scene below this height [m], as
in scenarios."""


@dc.dataclass(frozen=True)
class _Question:
    """A generated scene, for which the filter must decide."""

    family: str
    seed: int
    criteria: FeasibilityFilter


def feasible_seeds(
    family: str,
    count: int,
    criteria: FeasibilityFilter,
    folder: Path,
    jobs: int = 0,
    on_found: Callable[[int], None] = lambda found: None,
) -> list[int]:
    """Returns the first seeds of a family whose scenes pass the filter.

    Results are stored when enough seeds are found, and when the search is
    interrupted.

    Args:
        family: Name of the family, one of `FAMILIES`.
        count: Number of seeds.
        criteria: Criteria of the filter.
        folder: Folder in which results are stored.
        jobs: Number of worker processes; 0: the calling process does the work.
            The result does not depend on this number.
        on_found: Callback for the number of seeds found so far.

    Raises:
        RemoSplatError: The filter cannot be applied to a scene.
    """
    robot = _robot(criteria.spheres)
    path = folder / f"feasible-{family}-{_digest(robot, criteria)}.json"
    decisions = _read(path)
    known = len(decisions)
    try:
        if sum(decisions) < count:
            _decide(family, count, criteria, decisions, jobs, on_found)
    finally:
        if len(decisions) > known:
            write_atomically(path, json.dumps(decisions))
    return [seed for seed, good in enumerate(decisions) if good][:count]


def _decide(
    family: str,
    count: int,
    criteria: FeasibilityFilter,
    decisions: list[bool],
    jobs: int,
    on_found: Callable[[int], None],
):
    """Appends decisions in the order of the seeds, until `count` are good."""
    questions = (
        _Question(family, seed, criteria) for seed in count_from(len(decisions))
    )
    early: dict[int, bool] = {}
    with closing(run_all(_answer, questions, jobs)) as answers:
        for seed, is_good in answers:
            early[seed] = is_good
            while len(decisions) in early and sum(decisions) < count:
                decisions.append(early.pop(len(decisions)))
            on_found(sum(decisions))
            if sum(decisions) >= count:
                return


def _answer(question: _Question) -> tuple[int, bool]:
    """The scene's seed, and whether the scene passes."""
    scene = generate(question.family, question.seed)
    robot = _robot(question.criteria.spheres)
    return question.seed, passes(robot, scene, question.criteria)


@lru_cache(maxsize=4)
def _robot(spheres: str) -> RobotModel:
    return load_robot(ROBOT, spheres, FLOOR_HEIGHT)


def _digest(robot: RobotModel, criteria: FeasibilityFilter) -> str:
    """Returns a digest of everything on which a decision depends."""
    digest = hashlib.sha256()
    digest.update(repr((GENERATOR_VERSION, FILTER_VERSION, criteria)).encode())
    digest.update(robot.spheres.p_LS.tobytes())
    digest.update(robot.spheres.radius.tobytes())
    return digest.hexdigest()[:12]


def _read(path: Path) -> list[bool]:
    """Reads the decisions by seed; a damaged file counts as none."""
    try:
        decisions = parse_json(path.read_text(), path)
    except (OSError, ValueError, FileError):
        return []
    good = isinstance(decisions, list) and all(
        isinstance(decision, bool) for decision in decisions
    )
    return decisions if good else []
