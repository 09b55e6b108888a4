"""The scenes that methods are compared in, as small picklable names."""

import dataclasses as dc
import hashlib
from collections.abc import Sequence
from functools import cache
from itertools import chain, groupby, zip_longest
from pathlib import Path

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FileError, RemoSplatError, unknown_name
from remosplat_drake.benchmark.reaching_task import (
    SURFEL,
    TRAINED,
    BenchmarkCase,
    ReachingTask,
    solid_task,
)
from remosplat_drake.benchmark.scan_suite import scan_cases
from remosplat_drake.benchmark.splat_record import read_record
from remosplat_drake.generation.feasibility import FeasibilityFilter
from remosplat_drake.generation.feasible_scenes import feasible_seeds
from remosplat_drake.generation.primitive_surfels import (
    SURFEL_COUNT,
    surfel_splat,
)
from remosplat_drake.generation.scene_generators import (
    FAMILIES,
    GENERATOR_VERSION,
    PUBLISHED_FAMILIES,
    generate,
)
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene
from remosplat_drake.splat.codecs.ply import read_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat

PUBLISHED_FOLDERS = {"table": "table_new", "bookshelf": "bookshelf_cage"}
"""Folders of the published scenes, by family."""


@dc.dataclass(frozen=True)
class SceneCase:
    """One scene of a suite, and where its splat is.

    Attributes:
        name: Name of the scene in tables.
        family: Family of the scene; scenes of a family are reported together.
        suite: Name of the suite in titles of tables.
        file: Path of the scene's RMMI file; empty for a generated scene.
        seed: Seed of a generated scene.
        splat_folders: Folders in which trained splats may lie: as NAME.ply, as
            FAMILY_NUMBER.ply with the number that ends the name, or as
            HASH.ply with the hash of the scene's content.
    """

    name: str
    family: str
    suite: str = ""
    file: str = ""
    seed: int = 0
    splat_folders: tuple[str, ...] = ()

    def truth(self) -> PrimitiveScene:
        """Reads or generates the scene, with its task.

        Raises:
            RemoSplatError: Its file cannot be used, or it has no task.
        """
        if not self.file:
            return generate(self.family, self.seed)
        scene = read_scene(self.file)
        if scene.X_WE_target is None or scene.X_WB_start is None:
            raise FileError(self.file, "has no target or no robot_base")
        return scene

    def trained_splat(self, truth: PrimitiveScene) -> Path | None:
        """Returns the file of the scene's trained splat; None without one."""
        for folder in self.splat_folders:
            number = self.name.rpartition("_")[2]
            short = f"{self.family}_{number}"
            for stem in (truth.content_hash, self.name, short):
                path = Path(folder) / f"{stem}.ply"
                if path.is_file():
                    return path
        return None

    def task(self) -> ReachingTask:
        """Returns the target, and the true geometry of the scene.

        Raises:
            RemoSplatError: The scene's file cannot be used, or it has no task.
        """
        return solid_task(self.truth())

    def splat_key(self) -> str:
        """Returns the trained splat's digest; "surfel" where there is none."""
        path = self.trained_splat(self.truth())
        if path is None:
            return SURFEL
        status = path.stat()
        return f"{path.name}-{_digest(path, status.st_mtime_ns)}"

    def splat(self) -> tuple[GaussianSplat, str]:
        """Returns the scene's splat in W and its origin as tables name it.

        Without a trained one it is made of surfels on the true geometry.
        """
        truth = self.truth()
        path = self.trained_splat(truth)
        if path is not None:
            record = read_record(path)
            return read_ply(path), record.origin if record else TRAINED
        return surfel_splat(truth, SURFEL_COUNT), SURFEL


def interleave_families(
    cases: Sequence[BenchmarkCase],
) -> list[BenchmarkCase]:
    """Orders cases: the first of each family, then the second of each, ...

    Whenever a run stops, it has compared methods in balanced scenes.
    """
    by_family = [
        list(group) for _, group in groupby(cases, key=lambda c: c.family)
    ]
    turns = chain.from_iterable(zip_longest(*by_family))
    return [case for case in turns if case is not None]


@cache
def _digest(path: Path, modified: int) -> str:
    """Returns a file's digest, cached until its modification time changes."""
    del modified
    return hashlib.sha256(path.read_bytes()).hexdigest()


def load_cases(
    name: str,
    count: int,
    splat_folders: tuple[Path, ...] = (),
    trained_only: bool = False,
) -> Sequence[BenchmarkCase]:
    """Returns the cases of any suite.

    Args:
        name: "scan:NAME" for scanned scenes (`scan_cases`), else a name that
            `load_suite` takes.
        count: How many scenes of each family; scanned scenes are all taken.
        splat_folders: Folders of trained splats; scanned scenes use those
            that their suite names.
        trained_only: Whether scenes without a trained splat are left out.

    Raises:
        RemoSplatError: The suite does not exist or cannot be used.
    """
    kind, _, scans = name.partition(":")
    if kind == "scan":
        return scan_cases(scans)
    return load_suite(name, count, splat_folders, trained_only)


def load_suite(
    name: str,
    count: int,
    splat_folders: tuple[Path, ...] = (),
    trained_only: bool = False,
) -> list[SceneCase]:
    """Returns the first scenes of each family of a suite.

    Args:
        name: "generated" for the published families,
            "generated:FAMILY,..." for chosen ones, or "published:DIR" with
            the folders of `PUBLISHED_FOLDERS` in DIR.
        count: Number of scenes of each family.
        splat_folders: Folders in which trained splats are looked for.
        trained_only: Whether scenes without a trained splat are left out.

    Raises:
        RemoSplatError: The suite does not exist, or it has no scenes.
    """
    kind, _, folder = name.partition(":")
    if kind == "published" and folder:
        cases = _published(Path(folder))
    elif kind == "generated":
        families = folder.split(",") if folder else PUBLISHED_FAMILIES
        cases = _generated(count, families)
    else:
        raise RemoSplatError(
            f"--suite: unknown suite {name!r}; valid: generated,"
            " generated:FAMILY,..., published:DIR, scan:NAME[:DATA]"
        )
    folders = tuple(str(folder) for folder in splat_folders)
    chosen = []
    for family in FAMILIES:
        found = [
            dc.replace(case, splat_folders=folders)
            for case in cases
            if case.family == family
        ]
        if trained_only:
            found = [c for c in found if c.trained_splat(c.truth())]
        chosen += found[:count]
    if not chosen:
        raise RemoSplatError(f"--suite: {name} has no scenes to run")
    return chosen


def _published(folder: Path) -> list[SceneCase]:
    cases = []
    for family, stem in PUBLISHED_FOLDERS.items():
        files = sorted((folder / stem).glob(f"{stem}_*.json"))
        if not files:
            raise FileError(folder / stem, f"holds no {stem}_*.json")
        cases += [
            SceneCase(f.stem, family, "published scenes", str(f)) for f in files
        ]
    return cases


def _generated(count: int, families: Sequence[str]) -> list[SceneCase]:
    for family in families:
        if family not in FAMILIES:
            problem = unknown_name("scene family", family, FAMILIES)
            raise RemoSplatError(f"--suite: {problem}")
    criteria = FeasibilityFilter()
    suite = f"generated scenes v{GENERATOR_VERSION}, {criteria.name}"
    return [
        SceneCase(generate(family, seed).name, family, suite, seed=seed)
        for family in families
        for seed in feasible_seeds(
            family, count, criteria, resources.cache_dir()
        )
    ]
