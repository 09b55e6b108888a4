"""`remosplat reconstruct`: a splat from an RGB-D capture."""

import argparse
from pathlib import Path

import numpy as np
from rich.console import Console

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.formats import read_capture
from remosplat_drake.errors import FieldError, MissingExtraError
from remosplat_drake.reconstruction.surfels import (
    Surfels,
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.resources import resolve
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.ply import write_ply


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the command's flags."""
    parser.add_argument(
        "folder", metavar="FOLDER", help="a nerfstudio folder with depth"
    )
    parser.add_argument("output", metavar="SPLAT.ply", type=Path)
    parser.add_argument(
        "--count", type=int, default=60_000, help="splats at most (60000)"
    )
    parser.add_argument(
        "--focus",
        type=float,
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="where the splats are finest (default: everywhere alike)",
    )
    parser.add_argument(
        "--steps", type=int, default=2000, help="of training (2000)"
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--untrained",
        action="store_true",
        help="lay discs on the measured surfaces and stop: needs no GPU",
    )


def run(arguments: argparse.Namespace) -> int:
    """Reconstructs the capture."""
    for name in ("count", "steps"):
        if getattr(arguments, name) < 1:
            raise FieldError("reconstruct", f"--{name}", "must be positive")
    console = Console()
    capture = read_capture(resolve(arguments.folder))
    focus = None if arguments.focus is None else np.array(arguments.focus)
    surfels = surfels_from_capture(capture, arguments.count, focus)
    console.print(f"{len(capture)} views, {len(surfels)} surfels")
    splat = (
        splat_of_surfels(surfels)
        if arguments.untrained
        else _train(capture, surfels, arguments, console)
    )
    write_ply(arguments.output, splat, with_normals=False)
    console.print(f"{len(splat)} splats in {arguments.output}")
    return 0


def _train(
    capture: Capture,
    surfels: Surfels,
    arguments: argparse.Namespace,
    console: Console,
) -> GaussianSplat:
    try:
        from remosplat_drake.reconstruction import training
    except ImportError as error:
        raise MissingExtraError(
            "training a splat (all but --untrained)", "gpu"
        ) from error
    return training.train(
        capture,
        splat_of_surfels(surfels, opacity=0.7),
        training.TrainingConfig(steps=arguments.steps, seed=arguments.seed),
    ).splat
