"""The seeds of generated scenes that pass the feasibility filter.

Decisions are stored in a file, since the search for an unreachable goal takes
seconds.
"""

import hashlib
import json
from pathlib import Path

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError
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

ROBOT, FLOOR_HEIGHT = "frankie", 0.03
"""Robot that must reach the goals, and the height below which its floor links
ignore everything, as in scenarios [m]."""


def feasible_seeds(
    family: str, count: int, criteria: FeasibilityFilter, folder: Path
) -> list[int]:
    """Returns the first seeds of a family whose scenes pass the filter.

    Args:
        family: Name of the family, one of `FAMILIES`.
        count: Number of seeds.
        criteria: Criteria of the filter.
        folder: Folder in which decisions are kept.
    """
    robot = load_robot(ROBOT, criteria.spheres, FLOOR_HEIGHT)
    path = folder / f"feasible-{family}-{_digest(robot, criteria)}.json"
    decisions = _read(path)
    known = len(decisions)
    while sum(decisions) < count:
        scene = generate(family, len(decisions))
        decisions.append(passes(robot, scene, criteria))
    if len(decisions) > known:
        write_atomically(path, json.dumps(decisions))
    return [seed for seed, good in enumerate(decisions) if good][:count]


def _digest(robot: RobotModel, criteria: FeasibilityFilter) -> str:
    """Returns a digest of all that a decision depends on."""
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
