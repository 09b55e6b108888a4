"""The paper's experiment 3: effects of floaters on distance methods.

Every method measures distances at random robot states, against the truth,
and drives the robot to the scene's target from several starts.
"""

import dataclasses as dc
from collections.abc import Iterator

import numpy as np

from apps.studies.robot_states import distance_errors, free_states
from remosplat_drake.app.diagram import build
from remosplat_drake.app.run_result import REACHED
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import World
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.resources import models_dir, resolve
from remosplat_drake.generation.floaters import with_floaters
from remosplat_drake.oracle.oracle_config import (
    DepthRasterization,
    OracleConfig,
    SphereToEllipsoid,
    make_field,
)
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.reconstruction.report.quality import (
    DistanceQuality,
    summarize,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.formats import read_splat
from remosplat_drake.splat.gaussian_splat import GaussianSplat

METHODS: dict[str, OracleConfig] = {
    "depth rasterisation": DepthRasterization(),
    "ellipsoids, min_opacity 0": SphereToEllipsoid(min_opacity=0.0),
    "ellipsoids, min_opacity 0.1": SphereToEllipsoid(min_opacity=0.1),
}
"""Distance oracles to compare, by name: the paper's two and the remedy."""

DEMOS = ("table", "bookshelf")
"""Folders of the shipped scenes."""

PERIOD, TIME_LIMIT = 0.05, 15.0
"""Control period and time limit of a run [s]."""

START_SPREAD = (0.1, 0.3, 0.3)
"""Largest distance of starts from the scene's own: x, y, yaw [m, m, rad]."""

START_CLEARANCE = 0.05
"""Smallest clearance of the robot from the true scene at the start [m]."""


@dc.dataclass(frozen=True, eq=False)
class NoiseScene:
    """A splat, and the geometry that it represents.

    Attributes:
        name: Name of the scene in tables.
        splat_W: The splat, expressed in W.
        truth: The true solids, with the task.
    """

    name: str
    splat_W: GaussianSplat
    truth: PrimitiveScene

    def __post_init__(self):
        if self.truth.X_WE_target is None or self.truth.X_WB_start is None:
            raise RemoSplatError(f"{self.name}: the truth has no task")


@dc.dataclass(frozen=True)
class Accuracy:
    """Distance errors of one method in one scene.

    Attributes:
        quality: Summary of the errors over all spheres.
        quantiles: 0, 1, 50, 99 and 100 % quantiles of the signed errors [m].
    """

    quality: DistanceQuality
    quantiles: tuple[float, ...]


@dc.dataclass(frozen=True)
class NoisyRun:
    """The result of one run of one method.

    Attributes:
        reached: Whether the target was reached.
        truth_clearance_min: Smallest true clearance during the run [m].
        start_clearance: Clearance that the method measured before the first
            tick [m].
        position_error: Distance of the end effector from the target at the end
            [m].
        duration: Simulated time of the run [s].
    """

    reached: bool
    truth_clearance_min: float
    start_clearance: float
    position_error: float
    duration: float

    @property
    def success(self) -> bool:
        """Whether the robot reached the target and touched nothing."""
        return self.reached and self.truth_clearance_min > 0


def scene_from_files(splat: str, truth: str) -> NoiseScene:
    """Reads a scene from a splat file and an RMMI file in a common frame W."""
    path = resolve(splat)
    return NoiseScene(path.stem, read_splat(path), read_scene(resolve(truth)))


def demo_scenes(floaters: int, seed: int) -> Iterator[NoiseScene]:
    """Yields the shipped scenes, each unchanged and with floaters added."""
    for name in DEMOS:
        folder = models_dir() / "scenes" / name
        splat_W = read_splat(folder / "splat.ply")
        truth = read_scene(folder / "scene.json")
        yield NoiseScene(name, splat_W, truth)
        noisy = with_floaters(
            splat_W, SignedDistanceField(truth), floaters, seed
        )
        yield NoiseScene(f"{name} + {floaters} floaters", noisy, truth)


def method_field(scene: NoiseScene, method: str) -> DistanceField:
    """Makes a method's distance field of a scene's splat."""
    return make_field(
        METHODS[method], scene.splat_W, scene.truth, "noise experiment"
    )


def measure_accuracy(
    robot: RobotModel,
    scene: NoiseScene,
    field: DistanceField,
    states: int,
    seed: int,
) -> Accuracy:
    """Measures a field's errors over the spheres of random free states.

    Args:
        robot: Model of the robot.
        scene: Scene whose truth the field is compared with.
        field: Distances to the scene's splat.
        states: Number of random states.
        seed: Seed of the random states.
    """
    truth = SignedDistanceField(scene.truth)
    q = free_states(robot, truth, states, seed)
    error, _ = distance_errors(robot, field, truth, q)
    quantiles = np.quantile(error, (0, 0.01, 0.5, 0.99, 1)).tolist()
    return Accuracy(summarize(error), tuple(quantiles))


def random_starts(
    robot: RobotModel, truth: PrimitiveScene, count: int, seed: int
) -> np.ndarray:
    """Returns the scene's start and others around it, shape (count, n_q)."""
    rng = np.random.default_rng(seed)
    field = SignedDistanceField(truth)
    home = np.array([*(truth.X_WB_start or (0, 0, 0)), *robot.home])
    starts = [home]
    while len(starts) < count:
        q = home.copy()
        q[:3] += rng.uniform(-1, 1, 3) * START_SPREAD
        if field.clearances(robot.spheres_at(q)).minimum() > START_CLEARANCE:
            starts.append(q)
    return np.array(starts[:count])


def run_trial(
    robot: RobotModel, scene: NoiseScene, field: DistanceField, q0: np.ndarray
) -> NoisyRun:
    """Drives the robot from q0 with the tuned gains, checked by the same map.

    Args:
        robot: Model of the robot.
        scene: Scene with the target and the truth.
        field: Distances that the controller uses.
        q0: Configuration at the start, shape (n_q,).
    """
    scenario = Scenario(
        control_period=PERIOD, time_limit=TIME_LIMIT, source=scene.name
    )
    world = World(robot, scene.splat_W, scene.truth, field, q0)
    result = run(build(scenario, world))
    clearance = result.metrics.truth_clearance_min
    return NoisyRun(
        reached=result.outcome == REACHED,
        truth_clearance_min=np.inf if clearance is None else clearance,
        start_clearance=field.clearances(robot.spheres_at(q0)).minimum(),
        position_error=result.position_error,
        duration=result.metrics.duration,
    )
