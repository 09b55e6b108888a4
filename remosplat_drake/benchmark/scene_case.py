"""`SceneCase`: a scene of solids in a benchmark, with its splat."""

import dataclasses as dc
import hashlib
from functools import cache
from pathlib import Path

from remosplat_drake.base.errors import FileError
from remosplat_drake.benchmark.reaching_task import (
    SURFEL,
    TRAINED,
    ReachingTask,
    solid_task,
)
from remosplat_drake.benchmark.splat_record import read_record
from remosplat_drake.generation.primitive_surfels import (
    SURFEL_COUNT,
    surfel_splat,
)
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene
from remosplat_drake.splat.codecs.ply import read_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat


@dc.dataclass(frozen=True)
class SceneCase:
    """One scene of a suite, and the folders of its splat.

    Attributes:
        name: Name of the scene in tables.
        family: Family of the scene; scenes of a family are reported together.
        suite: Name of the suite in titles of tables.
        file: Path of the scene's RMMI file; empty for a generated scene.
        seed: Seed of a generated scene.
        splat_folders: Folders that are searched for a trained splat, in a file
            NAME.ply, FAMILY_NUMBER.ply (with the number at the end of the
            name), or HASH.ply (with the hash of the scene's content).
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
            RemoSplatError: The scene's file cannot be used, or contains no
                task.
        """
        if not self.file:
            return generate(self.family, self.seed)
        scene = read_scene(self.file)
        if scene.X_WE_target is None or scene.X_WB_start is None:
            raise FileError(self.file, "needs a target and a robot_base")
        return scene

    def trained_splat(self, truth: PrimitiveScene) -> Path | None:
        """Returns the file of the scene's trained splat, or None."""
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
        """Returns the trained splat's name and digest, or "surfel"."""
        path = self.trained_splat(self.truth())
        if path is None:
            return SURFEL
        status = path.stat()
        return f"{path.name}-{_digest(path, status.st_mtime_ns)}"

    def splat(self) -> tuple[GaussianSplat, str]:
        """Returns the scene's splat in W, and its origin's name in tables.

        If there is no trained splat, the splat consists of surfels on the true
        geometry.
        """
        truth = self.truth()
        path = self.trained_splat(truth)
        if path is not None:
            record = read_record(path)
            return read_ply(path), record.origin if record else TRAINED
        return surfel_splat(truth, SURFEL_COUNT), SURFEL


@cache
def _digest(path: Path, modified: int) -> str:
    """Returns a file's digest; cached for the same modification time."""
    del modified
    return hashlib.sha256(path.read_bytes()).hexdigest()
