"""Loads targets in scanned scenes, as in the paper's experiments 2 and 3."""

import dataclasses as dc
from pathlib import Path
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError, FileError, unknown_name
from remosplat_drake.base.pose_config import PoseConfig, make_transform
from remosplat_drake.base.ranges import Config, Position, Seed
from remosplat_drake.base.strict_yaml import entries, load_strict
from remosplat_drake.benchmark.capture_truth import (
    capture_field,
    content_digest,
)
from remosplat_drake.benchmark.paper_results import NOISY_SCAN, SCAN
from remosplat_drake.benchmark.reaching_task import (
    TRAINED,
    ReachingTask,
    solid_task,
)
from remosplat_drake.generation.floaters import with_floaters
from remosplat_drake.scene.rmmi import read_scene
from remosplat_drake.splat.formats import read_splat
from remosplat_drake.splat.gaussian_splat import GaussianSplat

SCANS_DIR = Path(__file__).parent / "scans"
"""Folder of the shipped suites of scanned scenes."""


@dc.dataclass
class SolidsTruth(Config):
    """Ground truth as solids: those of an RMMI file, whose task is ignored."""

    file: str = ""


@dc.dataclass
class CaptureTruth(Config):
    """Ground truth in the form of a capture's depth, if solids are unknown."""

    # A capture in a format that `remosplat capture-info` reads.
    folder: str = ""
    # Pose of the capture's world frame in W.
    X_WG: PoseConfig = dc.field(default_factory=PoseConfig)
    # Largest depth that is accurate enough to detect collisions [m].
    max_depth: Annotated[float, Interval(gt=0, le=100)] = 3.5


@dc.dataclass
class MapConfig(Config):
    """One splat of the scene, and its processing."""

    splat: str = ""
    # Pose of the splat's frame in W.
    X_WG: PoseConfig = dc.field(default_factory=PoseConfig)
    # Number of faint discs that are added in free space, and the seed of their
    # positions; see `with_floaters`.
    floaters: Annotated[int, Interval(ge=0, le=1_000_000)] = 0
    seed: Seed = 0
    # Whether results are compared with the paper's experiment 3 instead of
    # experiment 2. If there are `floaters`, they always are.
    noisy: bool = False


@dc.dataclass
class ScannedScene(Config):
    """A scanned scene; each target is tried on each map."""

    # Folder of the files that the fields below name, relative to this file.
    data: str = "."
    truth: SolidsTruth | CaptureTruth = dc.field(default_factory=SolidsTruth)
    # Pose of the base at the start: x, y, yaw in W [m, m, rad].
    start: Position = dc.field(default_factory=lambda: [0.0] * 3)
    # End-effector poses in W, by name.
    targets: dict[str, PoseConfig] = dc.field(default_factory=dict)
    # Maps, by name.
    maps: dict[str, MapConfig] = dc.field(default_factory=dict)


@dc.dataclass(frozen=True)
class ScanCase:
    """One target on one map of a scanned scene.

    Attributes:
        file: Path of the suite's file.
        scene: Name of the scene in the suite.
        map: Name of the map of that scene.
        target: Name of the target in that scene.
        data: Folder of the data files; empty for the folder that the suite
            names.
    """

    file: str
    scene: str
    map: str
    target: str
    data: str = ""

    @property
    def name(self) -> str:
        """Name of the case: scene, map and target."""
        return f"{self.scene}/{self.map}/{self.target}"

    @property
    def family(self) -> str:
        """Family of the case: the paper's experiment that it repeats."""
        entry = self._map()
        return NOISY_SCAN if entry.noisy or entry.floaters else SCAN

    @property
    def suite(self) -> str:
        """Title of the case's suite: scene and map."""
        return f"{self.scene}, {self.map} map"

    def task(self) -> ReachingTask:
        """Returns the target, and the known surfaces of the scene."""
        config = self._config()
        X_WT = make_transform(
            config.targets[self.target], self._where, f"targets.{self.target}"
        )
        x, y, yaw = config.start
        if not isinstance(config.truth, CaptureTruth):
            solids = read_scene(self._path(config.truth.file, "truth.file"))
            return solid_task(
                dc.replace(solids, X_WE_target=X_WT, X_WB_start=(x, y, yaw))
            )
        folder = self._path(config.truth.folder, "truth.folder")
        X_WG = make_transform(config.truth.X_WG, self._where, "truth.X_WG")
        rows = tuple(X_WG.GetAsMatrix34().ravel().tolist())
        reach = config.truth.max_depth
        return ReachingTask(
            X_WT,
            (x, y, yaw),
            f"{content_digest(folder)}-{(rows, reach)}",
            lambda: capture_field(folder, rows, reach),
        )

    def splat_key(self) -> str:
        """Returns a digest of the splat's file and of its processing."""
        entry = self._map()
        return f"{content_digest(self._splat_path())}-{entry}"

    def splat(self) -> tuple[GaussianSplat, str]:
        """Returns the map in W, with its floaters, and its origin."""
        entry = self._map()
        X_WG = make_transform(entry.X_WG, self._where, f"maps.{self.map}.X_WG")
        splat_G = read_splat(self._splat_path(), harmonics=False)
        splat_W = splat_G.transformed(X_WG)
        if not entry.floaters:
            return splat_W, TRAINED
        noisy = with_floaters(
            splat_W, self.task().truth_field, entry.floaters, entry.seed
        )
        return noisy, f"{TRAINED} with {entry.floaters} floaters"

    def check(self) -> None:
        """Checks, before any trial, that the case's files can be used.

        It also computes and caches a capture's surfaces, so that workers only
        read them.
        """
        self._splat_path()
        self.task().measure_truth()

    @property
    def _where(self) -> str:
        return f"{self.file}:{self.scene}"

    def _config(self) -> ScannedScene:
        return load_scan(Path(self.file), self.scene, self.data)

    def _map(self) -> MapConfig:
        return self._config().maps[self.map]

    def _splat_path(self) -> Path:
        return self._path(self._map().splat, f"maps.{self.map}.splat")

    def _path(self, uri: str, field: str) -> Path:
        data = self._config().data
        try:
            if not uri:
                raise FileError(data, "names no file")
            return resources.resolve(uri, Path(data))
        except FileError as error:
            raise FieldError(
                self._where,
                field,
                f"{error} in {data}; set another folder by"
                " --suite scan:NAME:FOLDER",
            ) from error


def scan_cases(name: str) -> list[ScanCase]:
    """Returns all cases of a suite, in the order of the maps.

    Args:
        name: Name of a shipped suite, or path of a YAML file. A colon and the
            folder of the data files may follow, if it differs from the suite's.

    Raises:
        RemoSplatError: The suite does not exist or cannot be used.
    """
    suite, _, data = name.partition(":")
    path = find_suite(suite)
    cases = []
    for scene in scan_names(path):
        config = load_scan(path, scene, data)
        cases += [
            ScanCase(str(path), scene, entry, target, data)
            for entry in config.maps
            for target in config.targets
        ]
    for case in cases:
        case.check()
    return cases


def find_suite(name: str) -> Path:
    """Returns the file of a suite, given its shipped name or its path.

    Raises:
        RemoSplatError: The suite does not exist.
    """
    if Path(name).suffix in (".yaml", ".yml"):
        return resources.resolve(name)
    shipped = {path.stem: path for path in sorted(SCANS_DIR.glob("*.yaml"))}
    if name not in shipped:
        problem = unknown_name("scan suite", name, shipped)
        raise FileError("--suite", f"{problem}, or a YAML file")
    return shipped[name]


def load_scan(path: Path, scene: str, data: str = "") -> ScannedScene:
    """Loads one scene of a suite.

    Args:
        path: Path of the suite's file.
        scene: Name of the scene in the suite.
        data: Folder of the data files; empty for the folder that the suite
            names.

    Raises:
        RemoSplatError: A field has an unusable value.
    """
    config = load_strict(ScannedScene, path, scene)
    where = f"{path}:{scene}"
    config.data = data or str(resources.resolve(config.data, path.parent))
    for field in ("targets", "maps"):
        if not getattr(config, field):
            raise FieldError(where, field, "none given")
    return config


def scan_names(path: Path) -> list[str]:
    """Returns the names of a suite's scenes."""
    names = entries(path)
    if not names:
        raise FileError(path, "holds no scenes")
    return names
