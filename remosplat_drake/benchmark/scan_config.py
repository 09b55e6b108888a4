"""Scan suites as YAML: a scanned scene, maps of it, and targets in it."""

import dataclasses as dc
from pathlib import Path
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.app.scenario import PoseConfig
from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError, FileError, unknown_name
from remosplat_drake.base.ranges import Config, Position, Seed
from remosplat_drake.base.strict_yaml import entries, load_strict

SCANS_DIR = Path(__file__).parent / "scans"
"""The shipped suites."""


@dc.dataclass
class SolidsTruth(Config):
    """The scene's solids are known: an RMMI file, whose task is not used."""

    file: str = ""


@dc.dataclass
class CaptureTruth(Config):
    """Nobody knows the solids: the capture's own depth is the truth."""

    # A capture that `remosplat capture-info` understands.
    folder: str = ""
    # Pose of the capture's world frame in W.
    X_WG: PoseConfig = dc.field(default_factory=PoseConfig)
    # Depth beyond this is too coarse to judge by [m].
    max_depth: Annotated[float, Interval(gt=0, le=100)] = 3.5


@dc.dataclass
class MapConfig(Config):
    """One splat of the scene, and what is done to it."""

    splat: str = ""
    # Pose of the splat's frame in W.
    X_WG: PoseConfig = dc.field(default_factory=PoseConfig)
    # Faint discs to add in free space (see floaters.py), and their seed.
    floaters: Annotated[int, Interval(ge=0, le=1_000_000)] = 0
    seed: Seed = 0
    # Stands beside the paper's experiment 3, not 2; implied by `floaters`.
    noisy: bool = False


@dc.dataclass
class ScanConfig(Config):
    """A scanned scene: every target is a trial on every map."""

    # Folder of the files below, itself relative to this file.
    data: str = "."
    truth: SolidsTruth | CaptureTruth = dc.field(default_factory=SolidsTruth)
    # Base pose to start from: x, y, yaw [m, m, rad].
    start: Position = dc.field(default_factory=lambda: [0.0] * 3)
    # End-effector poses in W, by name.
    targets: dict[str, PoseConfig] = dc.field(default_factory=dict)
    # Maps, by name.
    maps: dict[str, MapConfig] = dc.field(default_factory=dict)


def find_suite(name: str) -> Path:
    """The file of a suite: a shipped name or a path.

    Raises:
        RemoSplatError: There is no such suite.
    """
    if Path(name).suffix in (".yaml", ".yml"):
        return resources.resolve(name)
    shipped = {path.stem: path for path in sorted(SCANS_DIR.glob("*.yaml"))}
    if name not in shipped:
        problem = unknown_name("scan suite", name, shipped)
        raise FileError("--suite", f"{problem}, or a YAML file")
    return shipped[name]


def load_scan(path: Path, scene: str, data: str = "") -> ScanConfig:
    """One scene of a suite.

    Args:
        path: The suite's file.
        scene: One of its entries.
        data: Folder of the data files, in place of the suite's own.

    Raises:
        RemoSplatError: A field is unusable.
    """
    config = load_strict(ScanConfig, path, scene)
    where = f"{path}:{scene}"
    config.data = data or str(resources.resolve(config.data, path.parent))
    for field in ("targets", "maps"):
        if not getattr(config, field):
            raise FieldError(where, field, "none given")
    return config


def scan_names(path: Path) -> list[str]:
    """The scenes of a suite."""
    names = entries(path)
    if not names:
        raise FileError(path, "holds no scenes")
    return names
