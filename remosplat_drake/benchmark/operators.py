"""Ten simulated operators: does anything that was mapped get touched?

Each wants anything at any time, inside of the furniture, too, while the map
changes; see `RandomOperator`. The judge is the truth, at every tick:

mapped: what the frames of the map measured and is still there.
scene: all there is, but for what nobody has seen since it came. Where what
    no camera has seen is free, a robot may touch that: it is told apart.
"""

import dataclasses as dc
import json
import shutil
from pathlib import Path
from time import perf_counter

import numpy as np

from remosplat_drake.benchmark.mapped_truth import MappedTruth
from remosplat_drake.benchmark.operated_run import operate
from remosplat_drake.errors import FileError
from remosplat_drake.mapping.config import OBSTACLE
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.recorded_run import RecordedRun, load_recorded_run
from remosplat_drake.recording.events import REQUEST
from remosplat_drake.resources import resolve
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scenario import LoadScenario
from remosplat_drake.scene.rmmi import read_rmmi
from remosplat_drake.world import load_world

SCENARIOS = ("StudioFree", "StudioLive")
"""They take turns."""

LATENCY = 3.0
"""A map takes effect so long after it was asked for [s]."""

MAPPED, SCENE, UNSEEN = "mapped", "scene", "unseen"
"""What was touched: see above; `unseen` came and no frame shows it yet."""

KINDS = (MAPPED, SCENE, UNSEEN)

_NEAR = 0.05
"""Beyond that nobody looks [m]."""


@dc.dataclass(frozen=True)
class OperatorTrial:
    """One operator.

    Attributes:
        scenario: What is operated.
        seed: The operator's.
        duration: In simulated time [s].
        folder: Gets the session.
        text: Laid over the scenario.
    """

    scenario: str
    seed: int
    duration: float
    folder: str
    text: str = f"{{mapping: {{latency: {LATENCY}}}}}"

    @property
    def key(self) -> str:
        """Equal keys, equal trials."""
        return f"{self.scenario} seed {self.seed} {self.duration:g} s"


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


def make_trials(
    count: int, minutes: float, seed: int, folder: Path
) -> list[OperatorTrial]:
    """The trials of a campaign, in the scenarios in turns."""
    return [
        OperatorTrial(
            SCENARIOS[i % len(SCENARIOS)],
            seed + i,
            60.0 * minutes,
            str(folder / f"operator_{seed + i:02d}"),
        )
        for i in range(count)
    ]


def run_operator(trial: OperatorTrial) -> OperatorResult:
    """Runs one operator and judges the session; it stays in its folder.

    A session that is there already was broken off, and is begun again.
    """
    start = perf_counter()
    folder = Path(trial.folder)
    if folder.exists():
        shutil.rmtree(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    scenario = LoadScenario(trial.scenario, trial.text)
    world = load_world(scenario, blank=True)
    run = operate(scenario, world, folder, trial.seed, trial.duration)
    result = dc.replace(
        judge(folder),
        key=trial.key,
        scenario=trial.scenario,
        seed=trial.seed,
        stops=run.stops,
        stopped=run.stopped,
    )
    return dc.replace(result, wall=perf_counter() - start)


def crashed(trial: OperatorTrial, error: str) -> OperatorResult:
    """The result of a trial that failed."""
    return OperatorResult(trial.key, trial.scenario, trial.seed, error=error)


def judge(folder: Path) -> OperatorResult:
    """Judges the latest run of a session by the truth.

    Raises:
        RemoSplatError: The session cannot be read.
    """
    run = load_recorded_run(folder)
    truth = _truth(run)
    clearance, deepest = _clearances(run, truth)
    # What anybody knows of is not unseen.
    fresh = np.where(clearance[SCENE] < 0, np.inf, clearance[UNSEEN])
    clearance[UNSEEN] = fresh
    touches = [
        touch
        for what in KINDS
        for touch in _touches(what, run, clearance[what], deepest[what])
    ]
    rows = run.log.rows
    known = rows["map_version"] > 0
    return OperatorResult(
        key="",
        scenario="",
        seed=0,
        careful=run.scenario.mapping.unknown == OBSTACLE,
        ticks=len(rows),
        maps=int((np.diff(rows["map_version"]) != 0).sum()),
        frames=len(run.session.frames.names),
        scene_changes=len(_scene_changes(run)),
        map_clearance=float(rows["clearance"][known].min(initial=np.inf)),
        mapped_clearance=float(clearance[MAPPED].min()),
        true_clearance=float(clearance[SCENE].min()),
        touches=tuple(touches),
        path_length=_path_length(rows["q"], run.world.robot),
    )


def _truth(run: RecordedRun) -> MappedTruth:
    assert run.world.truth is not None
    scenes = [run.world.truth]
    if uri := run.scenario.scene.truth_later:
        scenes.append(read_rmmi(resolve(uri, run.scenario.folder)))
    return MappedTruth(
        run.session,
        scenes,
        _scene_changes(run),
        run.scenario.mapping.max_depth,
    )


def _scene_changes(run: RecordedRun) -> list[float]:
    return [
        event.time
        for event in run.events
        if (event.kind, event.text) == (REQUEST, "scene")
    ]


def _clearances(
    run: RecordedRun, truth: MappedTruth
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Smallest distances at each tick, (T,) [m], and of which spheres, (T,).

    What is farther than `_NEAR` from all that there is counts as infinite.
    """
    rows, robot = run.log.rows, run.world.robot
    distance = {what: np.full(len(rows), np.inf) for what in KINDS}
    sphere = {what: np.zeros(len(rows), int) for what in KINDS}
    for k, row in enumerate(rows):
        version = max(int(row["map_version"]), 0)
        changes = truth.changes_before(float(row["time"]))
        spheres = robot.spheres_at(row["q"])
        everything = SignedDistanceField(truth.scene(changes))
        near = np.unique(everything.clearances(spheres, _NEAR).sphere)
        if not len(near):
            continue
        few = spheres.select(near)
        for what, field in (
            (MAPPED, truth.surfaces(version, changes)),
            (SCENE, SignedDistanceField(truth.known(version, changes))),
            (UNSEEN, everything),
        ):
            found = field.clearances(few, _NEAR)
            if len(found):
                nearest = int(found.distance.argmin())
                distance[what][k] = found.distance[nearest]
                sphere[what][k] = near[found.sphere[nearest]]
    return distance, sphere


def _touches(
    what: str, run: RecordedRun, distance: np.ndarray, sphere: np.ndarray
) -> list[Touch]:
    """The spans of ticks in which a distance is negative."""
    inside = np.concatenate([[False], distance < 0, [False]])
    starts, ends = np.flatnonzero(np.diff(inside)).reshape(-1, 2).T
    rows, robot = run.log.rows, run.world.robot
    touches = []
    for first, end in zip(starts, ends, strict=True):
        k = first + int(distance[first:end].argmin())
        spheres = robot.spheres_at(rows["q"][k])
        touches.append(
            Touch(
                what=what,
                start=float(rows["time"][first]),
                duration=float((end - first) * run.log.period),
                depth=float(-distance[k]),
                link=robot.spheres.links[sphere[k]],
                place=tuple(np.round(spheres.p_WS[sphere[k]], 3).tolist()),
                version=int(rows["map_version"][k]),
            )
        )
    return touches


def _path_length(q: np.ndarray, robot: RobotModel) -> float:
    p_WE = np.array([robot.end_effector_pose(each)[:3, 3] for each in q[::10]])
    return float(np.linalg.norm(np.diff(p_WE, axis=0), axis=1).sum())


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
            fields = json.loads(line)
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
