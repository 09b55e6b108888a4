"""`TrialResult`: what one trial leaves behind, as one line of JSON."""

import dataclasses as dc
import json
from pathlib import Path

from remosplat_drake.base.errors import FileError
from remosplat_drake.base.strict_json import parse_json

SUCCESS = "success"
COLLISION = "collision"
TIMEOUT = "timeout"
LOCAL_MINIMUM = "local minimum"
INFEASIBLE = "infeasible"
CRASH = "crash"

OUTCOMES = (SUCCESS, COLLISION, TIMEOUT, LOCAL_MINIMUM, INFEASIBLE, CRASH)
"""How a trial ends: well, or why not.

`timeout`: still moving when time was up. `local minimum`: standing still by
then. `infeasible`: its last program had no solution. `crash`: an error in
the software.
"""

RULES = ("text", "authors")
"""Success rules; see `ArrivalConfig`."""

RULE_TITLES = {
    "text": "success by the paper's text: 2 cm and 2 deg",
    "authors": "success as the authors' code has it: L1 < 2 cm, any rotation",
}


@dc.dataclass(frozen=True)
class Judgement:
    """One trial judged by one success rule, up to its arrival.

    Attributes:
        outcome: One of `OUTCOMES`.
        duration: Time to the target, or to the end [s].
        average_distance: D_avg, mean smallest true clearance [m].
        minimum_distance: Smallest true clearance at and between ticks [m].
        gracefulness: Mean |a_EE| by the authors' definition [m/s^2].
        acceleration: Mean |a_EE| that does not depend on the rate [m/s^2].
        path_length: Of the end effector [m].
        base_path_length: Of the base [m].
    """

    outcome: str
    duration: float
    average_distance: float
    minimum_distance: float
    gracefulness: float
    acceleration: float
    path_length: float
    base_path_length: float

    @property
    def success(self) -> bool:
        """Arrived and touched nothing."""
        return self.outcome == SUCCESS


@dc.dataclass(frozen=True)
class WallTimes:
    """How long things took on the machine; not part of what is repeatable.

    Attributes:
        solve_mean: Of the quadratic program [s].
        solve_std: Its standard deviation [s].
        tick_p50: Median of a whole control tick [s].
        tick_p99: 99th percentile of it [s].
        trial: The whole trial [s].
    """

    solve_mean: float
    solve_std: float
    tick_p50: float
    tick_p99: float
    trial: float


@dc.dataclass(frozen=True)
class TrialResult:
    """One method in one scene.

    Attributes:
        key: Names method, scene and all settings; equal keys, equal trials.
        method: Name of the method.
        scene: Name of the scene.
        family: Family of the scene.
        spheres: Sphere set of the robot.
        gains: Gain set that the method starts from.
        oracle: Distance method.
        splat: "none", "trained" or "surfel".
        splat_count: How many splats.
        station: "kinematic" or "dynamic".
        seed: Of everything random.
        version: Of this package.
        text: Judged by the paper's text.
        authors: Judged as the authors' code does.
        statuses: Number of ticks by status.
        times: Wall-clock times.
        suite: What the scenes are.
        error: What crashed; empty otherwise.
    """

    key: str
    method: str
    scene: str
    family: str
    spheres: str
    gains: str
    oracle: str
    splat: str
    splat_count: int
    station: str
    seed: int
    version: str
    text: Judgement | None = None
    authors: Judgement | None = None
    statuses: dict[str, int] = dc.field(default_factory=dict)
    times: WallTimes | None = None
    suite: str = ""
    error: str = ""

    def judged(self, rule: str) -> Judgement | None:
        """By one of `RULES`; None if the trial crashed."""
        return getattr(self, rule)

    def outcome(self, rule: str) -> str:
        """One of `OUTCOMES`, by one of `RULES`."""
        judgement = self.judged(rule)
        return CRASH if judgement is None else judgement.outcome

    def success(self, rule: str) -> bool:
        """Arrived by that rule and touched nothing."""
        return self.outcome(rule) == SUCCESS

    def repeatable(self) -> "TrialResult":
        """Without what depends on the machine's load."""
        return dc.replace(self, times=None)


def to_line(result: TrialResult) -> str:
    """One line of JSON, without its end."""
    return json.dumps(dc.asdict(result), sort_keys=True)


def from_line(line: str, where: str) -> TrialResult:
    """Reads what `to_line` wrote.

    Raises:
        FileError: It is something else.
    """
    try:
        fields = parse_json(line, where)
        for rule in RULES:
            if fields[rule] is not None:
                fields[rule] = Judgement(**fields[rule])
        if fields["times"] is not None:
            fields["times"] = WallTimes(**fields["times"])
        return TrialResult(**fields)
    except (ValueError, KeyError, TypeError) as error:
        raise FileError(
            where, f"is not a line of benchmark results ({error})"
        ) from error


def read_results(path: Path) -> list[TrialResult]:
    """The results in a file, the latest of each key; none without a file.

    A last line without an end was cut off while it was written; it does not
    count.

    Raises:
        FileError: The file cannot be read, or a line is something else.
    """
    try:
        text = path.read_text()
    except FileNotFoundError:
        return []
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, str(error)) from error
    lines = text.split("\n")[:-1]
    results = [from_line(x, f"{path}:{i}") for i, x in enumerate(lines, 1)]
    return list({result.key: result for result in results}.values())
