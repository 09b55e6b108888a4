"""Scan suites as YAML: a scanned scene, maps of it, and targets in it."""

import dataclasses as dc
from collections.abc import Sequence
from pathlib import Path

from remosplat_drake import resources
from remosplat_drake.errors import FieldError, FileError, unknown_name
from remosplat_drake.scenario import PoseConfig, make_transform
from remosplat_drake.strict_yaml import entries, load_strict

SCANS_DIR = Path(__file__).parent / "scans"
"""The shipped suites."""


@dc.dataclass
class SolidsTruth:
    """The scene's solids are known: an RMMI file, whose task is not used."""

    file: str = ""


@dc.dataclass
class CaptureTruth:
    """Nobody knows the solids: the capture's own depth is the truth."""

    # A capture that `remosplat capture-info` understands.
    folder: str = ""
    # Pose of the capture's world frame in W.
    X_WG: PoseConfig = dc.field(default_factory=PoseConfig)
    # Depth beyond this is too coarse to judge by [m].
    max_depth: float = 3.5


@dc.dataclass
class MapConfig:
    """One splat of the scene, and what is done to it."""

    splat: str = ""
    # Pose of the splat's frame in W.
    X_WG: PoseConfig = dc.field(default_factory=PoseConfig)
    # Faint discs to add in free space (see floaters.py), and their seed.
    floaters: int = 0
    seed: int = 0
    # Stands beside the paper's experiment 3, not 2; implied by `floaters`.
    noisy: bool = False


@dc.dataclass
class ScanConfig:
    """A scanned scene: every target is a trial on every map."""

    # Folder of the files below, itself relative to this file.
    data: str = "."
    truth: SolidsTruth | CaptureTruth = dc.field(default_factory=SolidsTruth)
    # Base pose to start from: x, y, yaw [m, m, rad].
    start: list[float] = dc.field(default_factory=lambda: [0.0] * 3)
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
    _check_entries(config.start, 3, where, "start")
    for field in ("targets", "maps"):
        if not getattr(config, field):
            raise FieldError(where, field, "none given")
    for name, target in config.targets.items():
        make_transform(target, where, f"targets.{name}")
    for name, entry in config.maps.items():
        make_transform(entry.X_WG, where, f"maps.{name}.X_WG")
        if entry.floaters < 0:
            raise FieldError(
                where, f"maps.{name}.floaters", "must not be negative"
            )
    if isinstance(config.truth, CaptureTruth):
        make_transform(config.truth.X_WG, where, "truth.X_WG")
    return config


def scan_names(path: Path) -> list[str]:
    """The scenes of a suite."""
    names = entries(path)
    if not names:
        raise FileError(path, "holds no scenes")
    return names


def _check_entries(
    values: Sequence[float], n: int, where: str, field: str
) -> None:
    if len(values) != n:
        raise FieldError(
            where, field, f"expected {n} numbers, got {len(values)}"
        )
