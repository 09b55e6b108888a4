"""`TrialResult`: the result of one trial, as one line of JSON."""

import dataclasses as dc
import json
from pathlib import Path

from remosplat_drake.base.errors import FileError
from remosplat_drake.base.strict_json import parse_json
from remosplat_drake.recording.mover_contacts import KINDS

SUCCESS = "success"
COLLISION = "collision"
TIMEOUT = "timeout"
LOCAL_MINIMUM = "local minimum"
INFEASIBLE = "infeasible"
ERROR = "error"
CRASH = "crash"

OUTCOMES = (
    SUCCESS,
    COLLISION,
    TIMEOUT,
    LOCAL_MINIMUM,
    INFEASIBLE,
    ERROR,
    CRASH,
)
"""Outcomes of a trial: success, or the reason of its failure.

`timeout`: the robot was still moving at the time limit. `local minimum`: the
robot stood still at the time limit. `infeasible`: the last quadratic program
had no solution. `error`: the scene cannot be used, because its file is invalid
or the robot would start inside an obstacle. `crash`: an error in the software.
"""

RULES = ("text", "authors")
"""Success rules: the paper's text and the authors' code (`ArrivalConfig`)."""

RULE_TITLES = {
    "text": "success by the paper's text: 2 cm and 2 deg",
    "authors": "success by the authors' code: L1 < 2 cm, any rotation",
}


@dc.dataclass(frozen=True)
class Judgement:
    """The judgement of a trial, up to the arrival, by one success rule.

    Attributes:
        outcome: One of `OUTCOMES`.
        duration: Time until the arrival, or else until the end of the run [s].
        average_distance: Mean over time of the smallest true clearance, D_avg
            in the paper [m].
        minimum_distance: Smallest true clearance at and between ticks [m].
        gracefulness: Mean acceleration of the end effector by the paper's
            definition [m/s^2].
        acceleration: Mean acceleration of the end effector, by a definition
            that hardly depends on the control rate [m/s^2].
        path_length: Path length of the end effector [m].
        base_path_length: Path length of the base [m].
        jerk: Largest jerk of the commands, relative to the arm's limits; None
            if the robot's description states no limits.
        torque: Largest torque that the commands require, relative to the
            motors' limits; None if the model file states no limits.
    """

    outcome: str
    duration: float
    average_distance: float
    minimum_distance: float
    gracefulness: float
    acceleration: float
    path_length: float
    base_path_length: float
    jerk: float | None = None
    torque: float | None = None

    @property
    def success(self) -> bool:
        """Whether the robot arrived without a collision."""
        return self.outcome == SUCCESS


@dc.dataclass(frozen=True)
class MovingResult:
    """True contacts and distances between the robot and movers.

    Attributes:
        movers: Number of movers. Each part of a moving object counts as a
            mover.
        contacts: Number of contacts of a link and a mover, by their kind
            (`recording.mover_contacts`).
        distance: Smallest distance of the robot from any mover [m].
        waited: Time in which no part of the robot moved [s].
    """

    movers: int
    contacts: dict[str, int]
    distance: float
    waited: float

    @property
    def worst(self) -> str:
        """The worst kind of contact; empty if there was no contact."""
        return next((kind for kind in KINDS if self.contacts.get(kind)), "")


@dc.dataclass(frozen=True)
class CarryingResult:
    """Result of a run in which the robot carries an object to the start's pose.

    Attributes:
        taken: Whether the robot grasped the object at the target.
        outcome: `COLLISION` if there was a collision at or between ticks;
            `SUCCESS` if there was none and the end effector is at the start's
            pose with the object; else `TIMEOUT`.
        reason: Reason why the run ended before the start's pose was reached;
            empty if it was reached.
        duration: Time from the grasp to the end of the run [s].
        minimum_distance: Least true distance, over the whole run, of robot and
            object from all solids and links that they must not touch [m].
    """

    taken: bool
    outcome: str
    reason: str
    duration: float
    minimum_distance: float


@dc.dataclass(frozen=True)
class WallTimes:
    """Wall-clock times of a trial, which differ from run to run.

    Attributes:
        solve_mean: Mean time to solve the quadratic program [s]. It is measured
            only if ticks run step by step, and is 0 if each tick is one
            compiled call.
        solve_std: Standard deviation of the time to solve the program [s].
        tick_p50: Median duration of a whole control tick [s].
        tick_p99: 99th percentile of the duration of a whole control tick [s].
        trial: Duration of the whole trial [s].
        first_path: Search time until the first path was found [s]; None if
            there was no search, or if it found no path.
    """

    solve_mean: float
    solve_std: float
    tick_p50: float
    tick_p99: float
    trial: float
    first_path: float | None = None


@dc.dataclass(frozen=True)
class TrialResult:
    """The result of one method in one scene.

    Attributes:
        key: Digest of the method, the scene and all settings. Trials with the
            same key have the same result.
        method: Name of the method.
        scene: Name of the scene.
        family: Family of the scene.
        spheres: Sphere set of the robot.
        gains: Name of the gain set on which the method's settings are based.
        oracle: Name of the distance oracle.
        splat: Origin of the splat: "none", "trained" or "surfel".
        splat_count: Number of splats in the map.
        station: Kind of the station: "kinematic" or "dynamic".
        seed: Seed of all random numbers of the trial.
        version: Version of this package that ran the trial.
        text: Judgement by the rule of the paper's text; None after an error
            or a crash.
        authors: Judgement by the rule of the authors' code; None after an
            error or a crash.
        statuses: Numbers of control ticks, keyed by the status of the tick.
        times: Wall-clock times; None after a crash.
        suite: Name of the suite.
        error: Error text of a crash; empty otherwise.
        problem: Reason, in one line, why the scene cannot be used; empty if it
            can be used.
        joint_time: Time of a straight path in joint space to the given goal, at
            the velocity limits [s]; None if no goal configuration is given.
        first_checks: Number of configurations and motions that were checked for
            collisions until the first path was found; None if no path was
            found.
        self_distance: Smallest distance between the hulls of two links that the
            robot keeps apart, at ticks [m]; negative if they overlap, and None
            if the robot keeps no links apart.
        moving: Contacts with movers, and distances from them; None without
            movers.
        carrying: Result of carrying the object back; None if no object is
            carried.
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
    problem: str = ""
    joint_time: float | None = None
    first_checks: int | None = None
    self_distance: float | None = None
    moving: MovingResult | None = None
    carrying: CarryingResult | None = None

    def judged(self, rule: str) -> Judgement | None:
        """Returns the judgement by a rule of `RULES`; None after a crash."""
        return getattr(self, rule)

    def outcome(self, rule: str) -> str:
        """Returns one of `OUTCOMES`, under the given rule of `RULES`."""
        judgement = self.judged(rule)
        if judgement is None:
            return ERROR if self.problem else CRASH
        return judgement.outcome

    def success(self, rule: str) -> bool:
        """Returns whether the trial is a success under the given rule."""
        return self.outcome(rule) == SUCCESS

    def repeatable(self) -> "TrialResult":
        """Returns a copy without values that depend on the machine's load."""
        return dc.replace(self, times=None)


def to_line(result: TrialResult) -> str:
    """Writes a result as one line of JSON, without the line end."""
    return json.dumps(dc.asdict(result), sort_keys=True)


def from_line(line: str, where: str) -> TrialResult:
    """Reads a result from a line of JSON that `to_line` wrote.

    Args:
        line: The line, without its end.
        where: The file and line number, for errors.

    Raises:
        FileError: The line does not contain a result.
    """
    try:
        fields = parse_json(line, where)
        for rule in RULES:
            if fields[rule] is not None:
                fields[rule] = Judgement(**fields[rule])
        if fields["times"] is not None:
            fields["times"] = WallTimes(**fields["times"])
        if fields.get("moving") is not None:
            fields["moving"] = MovingResult(**fields["moving"])
        if fields.get("carrying") is not None:
            fields["carrying"] = CarryingResult(**fields["carrying"])
        return TrialResult(**fields)
    except (ValueError, KeyError, TypeError) as error:
        raise FileError(
            where, f"is not a line of benchmark results ({error})"
        ) from error


def read_results(path: Path) -> list[TrialResult]:
    """Reads the results in a file; for each key, the latest one counts.

    A last line without a line end is ignored: its writing was interrupted.

    Returns:
        The results; an empty list if the file does not exist.

    Raises:
        FileError: The file cannot be read, or a line does not contain a result.
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
