"""`OperatorResult`: what came of a random operator, as one line of JSON."""

import dataclasses as dc
import json
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FileError
from remosplat_drake.base.strict_json import parse_json

MAPPED, SCENE, UNSEEN = "mapped", "scene", "unseen"
"""What was touched: see above; `unseen` came and no frame shows it yet."""

KINDS = (MAPPED, SCENE, UNSEEN)


@dc.dataclass(frozen=True)
class Touch:
    """One touch, from its first tick to its last.

    Attributes:
        what: MAPPED, SCENE or UNSEEN.
        start: [s].
        duration: [s].
        depth: How deep the robot's spheres got in [m].
        link: That was deepest.
        place: Where the deepest sphere was in W (3) [m].
        version: Of the map at the deepest tick.
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
    """What came of one operator.

    Attributes:
        key: Of the trial.
        scenario: Of the trial.
        seed: Of the trial.
        careful: Whether what no camera has seen was an obstacle.
        ticks: Control ticks.
        maps: Versions of the map that took effect.
        frames: That were asked for.
        scene_changes: How often a thing came or went.
        stops: Of the supervisor.
        stopped: How long the robot was stopped [s].
        map_clearance: Smallest by the map, once there was one [m].
        mapped_clearance: Smallest to what was mapped [m].
        true_clearance: Smallest to the scene as far as anybody knew it [m].
        touches: All touches.
        path_length: Of the end effector [m].
        wall: Time it took [s].
        error: What crashed; empty otherwise.
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
        """How many touches there were of a kind."""
        return sum(touch.what == what for touch in self.touches)

    @property
    def collisions(self) -> int:
        """Touches that must not be."""
        seen = self.count(MAPPED)
        return seen + (self.count(SCENE) if self.careful else 0)


def to_line(result: OperatorResult) -> str:
    """One line of JSON, without its end."""
    return json.dumps(dc.asdict(result), sort_keys=True)


def read_results(path: Path) -> dict[str, OperatorResult]:
    """What a file holds by key; crashes and a last line cut off do not count.

    Raises:
        FileError: The file cannot be read or holds something else.
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
