"""Flags of `remosplat benchmark` that select or make its scenes' splats."""

import argparse
import os
from pathlib import Path

from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.pool import VISIBLE_GPUS
from remosplat_drake.benchmark.runner import SplatMaking
from remosplat_drake.benchmark.splat_recipe import (
    default_folders,
    load_recipe,
)
from remosplat_drake.benchmark.trained_splats import FITS
from remosplat_drake.oracle.backend import missing_for_gsplat

JOBS_PER_GPU = 8
"""Default number of splats that are made at the same time on a GPU. Training of
a single splat does not use the GPU fully."""


def add_splat_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the flags for making splats."""
    group = parser.add_argument_group("splats")
    group.add_argument(
        "--splats",
        type=Path,
        action="append",
        default=[],
        metavar="DIR",
        help="folder of trained splats, as SCENE.ply (default: earlier"
        " splats of --train, or else surfels on the true geometry)",
    )
    either = group.add_mutually_exclusive_group()
    either.add_argument(
        "--trained-only",
        action="store_true",
        help="use only scenes with a trained splat",
    )
    either.add_argument(
        "--train",
        nargs="?",
        const="cuda",
        choices=list(FITS),
        help=(
            "for every scene without a splat, render views, make a splat of "
            "them, and keep it in the cache. cuda (default): train the splat "
            "on CUDA devices; cpu: refine it on the CPU"
        ),
    )
    group.add_argument(
        "--recipe",
        default="",
        metavar="YAML",
        help=(
            "YAML of settings that override those of --train, e.g. "
            "'{steps: 500, width: 320, height: 240}' (see "
            "benchmark/splat_recipe.py)"
        ),
    )
    group.add_argument(
        "--train-jobs",
        type=int,
        metavar="J",
        help=(
            "number of splats that are made at the same time, on all GPUs "
            f"together (default: as --jobs, at most {JOBS_PER_GPU} per GPU)"
        ),
    )


def splat_making(arguments: argparse.Namespace) -> SplatMaking | None:
    """Returns the settings for making splats; None without `--train`.

    Raises:
        RemoSplatError: A flag cannot be used on this machine.
    """
    if arguments.train is None:
        for flag in ("recipe", "train_jobs"):
            if getattr(arguments, flag):
                name = f"--{flag.replace('_', '-')}"
                raise FieldError("benchmark", name, "needs --train")
        return None
    if arguments.ray is not None:
        raise FieldError("benchmark", "--train", "cannot go with --ray")
    recipe = load_recipe(arguments.train, arguments.recipe)
    gpus = _gpus() if recipe.device == "cuda" else ()
    at_once = arguments.train_jobs
    if at_once is None:
        at_once = JOBS_PER_GPU * len(gpus) if gpus else arguments.jobs
    elif at_once < 1:
        problem = f"must be at least 1, got {at_once}"
        raise FieldError("benchmark", "--train-jobs", problem)
    return SplatMaking(recipe, min(at_once, arguments.jobs), gpus)


def splat_folders(
    arguments: argparse.Namespace, splats: SplatMaking | None
) -> tuple[Path, ...]:
    """Returns the folders of splats, beginning with the user's."""
    if splats is None:
        return (*arguments.splats, *default_folders())
    return (*arguments.splats, splats.recipe.folder)


def _gpus() -> tuple[str, ...]:
    """Returns the names of the GPUs that this process may use.

    Raises:
        RemoSplatError: There is no GPU, or a package is not installed.
    """
    problem = missing_for_gsplat()
    if problem:
        raise RemoSplatError(
            f"--train {problem}; use --train cpu, which refines the splats "
            "without training"
        )
    import torch

    named = os.environ.get(VISIBLE_GPUS, "")
    if named:
        return tuple(named.split(","))
    return tuple(str(i) for i in range(torch.cuda.device_count()))
