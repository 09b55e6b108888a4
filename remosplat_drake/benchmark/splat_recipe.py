"""Makes a scene's splat, and keeps it in the user's cache.

Each recipe, a set of settings, has its own folder in the user's cache. A splat
in this folder is named by the content of its scene. Scenes that differ only in
their target share a splat.
"""

import dataclasses as dc
import hashlib
from pathlib import Path
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.ranges import Config, OneOf, Seed
from remosplat_drake.base.strict_yaml import load_text
from remosplat_drake.benchmark.reaching_task import TRAINED
from remosplat_drake.scene.primitive_scene import PrimitiveScene

RECIPE_VERSION = 3
"""Version of the recipe. Increase it whenever the same settings would give
other splats."""

REFINED = "refined"
"""Origin, in tables, of a splat that was fitted on the CPU without
gradients."""

ORIGINS = {"cuda": TRAINED, "cpu": REFINED}
"""Origins of splats, in tables, keyed by the device that makes the splats."""


@dc.dataclass
class SplatRecipe(Config):
    """Settings of rendered views, and of the splats that are made from them."""

    # Device: `cpu` refines the discs; `cuda` refines and then trains them.
    device: Annotated[str, OneOf(tuple(ORIGINS), "device")] = "cuda"
    # Number of rendered views.
    views: Annotated[int, Interval(ge=1, le=10_000)] = 100
    # Size of a view [pixels].
    width: Annotated[int, Interval(ge=1, le=8192)] = 480
    height: Annotated[int, Interval(ge=1, le=8192)] = 360
    # Largest number of splats. The splats are smallest around the target.
    count: Annotated[int, Interval(ge=1, le=100_000_000)] = 60_000
    # Number of optimisation steps of a training. Refinement has no fixed number
    # of steps.
    steps: Annotated[int, Interval(ge=1, le=1_000_000)] = 300
    # Seed of all random numbers.
    seed: Seed = 0

    @property
    def origin(self) -> str:
        """Origin, in tables, of the recipe's splats."""
        return ORIGINS[self.device]

    @property
    def folder(self) -> Path:
        """Folder in which the recipe's splats are kept."""
        settings = repr((RECIPE_VERSION, self))
        digest = hashlib.sha256(settings.encode()).hexdigest()[:12]
        return resources.cache_dir() / "splats" / f"{self.origin}-{digest}"

    def splat_file(self, truth: PrimitiveScene) -> Path:
        """Returns the path of a scene's splat; the file need not exist."""
        return self.folder / f"{truth.content_hash}.ply"


def load_recipe(device: str, override: str = "") -> SplatRecipe:
    """Makes the recipe for a device, with overridden fields.

    Args:
        device: Device that makes the splats: "cuda" or "cpu".
        override: YAML that overrides fields, e.g. "{steps: 1000}".

    Raises:
        FieldError: A field is unknown, or its value is out of range.
        FileError: `override` is not YAML.
    """
    recipe = SplatRecipe(device=device)
    if override:
        recipe = load_text(SplatRecipe, override, "--recipe", recipe)
    if recipe.device != device:
        raise FieldError(
            "--recipe",
            "device",
            (f"must be absent, since --train {device} sets it"),
        )
    return recipe


def default_folders() -> tuple[Path, ...]:
    """Returns the default recipes' folders, those of trained splats first."""
    return tuple(SplatRecipe(device=device).folder for device in ORIGINS)
