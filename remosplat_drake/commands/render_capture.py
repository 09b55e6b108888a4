"""`remosplat render-capture`: RGB-D views of a scene of primitives."""

import argparse
from pathlib import Path

from rich.console import Console

from remosplat_drake.capture.nerfstudio import write_capture
from remosplat_drake.capture.synthetic import (
    render_capture,
    survey_poses,
)
from remosplat_drake.errors import FieldError
from remosplat_drake.resources import resolve
from remosplat_drake.scene.rmmi import read_rmmi


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the command's flags."""
    parser.add_argument("scene", metavar="SCENE", help="an RMMI JSON file")
    parser.add_argument("folder", metavar="FOLDER", type=Path)
    parser.add_argument("--views", type=int, default=120, help="how many (120)")
    parser.add_argument("--width", type=int, default=480, help="pixels (480)")
    parser.add_argument("--height", type=int, default=360, help="pixels (360)")
    parser.add_argument("--seed", type=int, default=0)


def run(arguments: argparse.Namespace) -> int:
    """Renders the capture."""
    for name in ("views", "width", "height"):
        if getattr(arguments, name) < 1:
            raise FieldError("render-capture", f"--{name}", "must be positive")
    scene = read_rmmi(resolve(arguments.scene))
    poses = survey_poses(scene, n=arguments.views, seed=arguments.seed)
    capture = render_capture(scene, poses, arguments.width, arguments.height)
    write_capture(arguments.folder, capture)
    Console().print(f"{len(capture)} views in {arguments.folder}")
    return 0
