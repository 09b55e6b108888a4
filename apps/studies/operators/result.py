"""`OperatorResult`: the result of a random operator, as one line of JSON."""

import dataclasses as dc
import json
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FileError
from remosplat_drake.base.strict_json import parse_json

MAPPED, SCENE, UNSEEN = "mapped", "scene", "unseen"
"""Kinds of touched objects: surfaces that a map measured, the known scene, and
new objects that no frame shows yet."""

KINDS = (MAPPED, SCENE, UNSEEN)


@dc.dataclass(frozen=True)
class Touch:
    """A touch, from its first tick to its last.

    Attributes:
        what: Kind of the touched object: MAPPED, SCENE or UNSEEN.
        start: Time of the first tick [s].
        duration: Time from the first tick to the last [s].
        depth: Largest penetration of the robot's spheres [m].
        link: Name of the link whose sphere was deepest.
        place: Position of the deepest sphere in W, shape (3,) [m].
        version: Version of the map at the deepest tick.
    """

    what: str
    start: float
    duration: float
    depth: float
    link: str
    place: tuple[float, ...]
    version: int


@dc.dataclass(frozen=True)
class OperatorResult:
    """The result of one operator's session.

    Attributes:
        key: Key of the trial.
        scenario: Name of the trial's scenario.
        seed: Seed of the trial's operator.
        careful: Whether unknown space was an obstacle.
        ticks: Number of control ticks.
        maps: Number of versions of the map that took effect.
        frames: Number of requested frames.
        scene_changes: Number of times that an object appeared or vanished.
        stops: Number of stops by the supervisor.
        stopped: Time for which the robot was stopped [s].
        map_clearance: Smallest distance by the map, after the first one [m].
        mapped_clearance: Smallest distance to mapped surfaces [m].
        true_clearance: Smallest distance to the known scene [m].
        touches: All touches.
        path_length: Path length of the end effector [m].
        wall: Wall-clock time of the trial [s].
        error: Error text of a crash; empty otherwise.
    """

    key: str
    scenario: str
    seed: int
    careful: bool = False
    ticks: int = 0
    maps: int = 0
    frames: int = 0
    scene_changes: int = 0
    stops: int = 0
    stopped: float = 0.0
    map_clearance: float = np.inf
    mapped_clearance: float = np.inf
    true_clearance: float = np.inf
    touches: tuple[Touch, ...] = ()
    path_length: float = 0.0
    wall: float = 0.0
    error: str = ""

    def count(self, what: str) -> int:
        """Returns the number of touches of a kind."""
        return sum(touch.what == what for touch in self.touches)

    @property
    def collisions(self) -> int:
        """Number of touches that are forbidden."""
        seen = self.count(MAPPED)
        return seen + (self.count(SCENE) if self.careful else 0)


def to_line(result: OperatorResult) -> str:
    """Writes a result as one line of JSON, without the line end."""
    return json.dumps(dc.asdict(result), sort_keys=True)


def read_results(path: Path) -> dict[str, OperatorResult]:
    """Reads a file's results by key, without crashes and a cut last line.

    Raises:
        FileError: The file cannot be read or does not hold results.
    """
    if not path.exists():
        return {}
    results = {}
    try:
        for line in path.read_text().split("\n")[:-1]:
            fields = parse_json(line, path)
            touches = tuple(
                Touch(**touch | {"place": tuple(touch["place"])})
                for touch in fields["touches"]
            )
            result = OperatorResult(**fields | {"touches": touches})
            if not result.error:
                results[result.key] = result
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise FileError(path, f"holds no such results ({error})") from error
    return results
