"""`remosplat render-capture`: renders RGB-D views of a known scene."""

import argparse
import dataclasses as dc
from functools import partial
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.atomic_file import check_writable
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.progress import Progress
from remosplat_drake.base.resources import resolve
from remosplat_drake.capture.checks.seen_space import look_round
from remosplat_drake.capture.images import MAX_PIXELS
from remosplat_drake.capture.readers.nerfstudio import TRANSFORMS, write_capture
from remosplat_drake.capture.rendering.camera_poses import (
    CLEARANCE,
    RADIUS,
    survey,
)
from remosplat_drake.capture.rendering.renderer import render_views
from remosplat_drake.capture.rendering.scene_files import read_solids
from remosplat_drake.capture.rendering.sensor_noise import (
    PRESETS,
    sensor_noise,
    with_noise,
)
from remosplat_drake.capture.rendering.solids import (
    Solid,
    extent,
    primitive_solids,
)
from remosplat_drake.commands.capture_flags import TRUTH
from remosplat_drake.commands.flags import (
    check_finite,
    check_positive,
    check_seed,
)
from remosplat_drake.commands.tables import open_console
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene, write_rmmi
from remosplat_drake.signals.distance_field import DistanceField


@dc.dataclass(frozen=True)
class _Subject:
    """The scene to render, its free space, and the box of the workspace."""

    solids: tuple[Solid, ...]
    field: DistanceField
    focus: np.ndarray
    radius: float
    truth: PrimitiveScene | None = None


EXAMPLES = """
remosplat render-capture scene.json capture --floor
remosplat render-capture scene.json capture --floor --noise kinect
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the command's flags."""
    parser.add_argument(
        "scene",
        metavar="SCENE",
        help="an RMMI .json, FAMILY:SEED of the benchmark's generator, a"
        " URDF, SDF or MJCF model, or a mesh (.obj, .gltf, .glb, .stl, .ply)",
    )
    parser.add_argument("folder", metavar="FOLDER", type=Path)
    parser.add_argument(
        "--views", type=int, default=120, help="number of views (120)"
    )
    parser.add_argument("--width", type=int, default=480, help="pixels (480)")
    parser.add_argument("--height", type=int, default=360, help="pixels (360)")
    parser.add_argument(
        "--seed", type=int, default=0, help="seed of all random numbers (0)"
    )
    parser.add_argument(
        "--floor", action="store_true", help="add a floor at z = 0"
    )
    parser.add_argument(
        "--noise",
        default="none",
        metavar="CAMERA",
        help=f"simulated imperfections of the camera: {', '.join(PRESETS)} "
        "(none)",
    )
    parser.add_argument(
        "--around",
        type=float,
        nargs=3,
        metavar=("X", "Y", "Z"),
        help=(
            "point that the cameras look at [m] (default: the scene's "
            "target, or the middle of a mesh); for a room, give a point in "
            "its free space"
        ),
    )
    parser.add_argument(
        "--radius",
        type=float,
        metavar="R",
        help=(
            "largest distance of the cameras from the point [m] "
            f"({RADIUS:g}, less for small meshes)"
        ),
    )
    parser.add_argument(
        "--place",
        type=float,
        nargs=4,
        metavar=("X", "Y", "Z", "YAW"),
        help="pose of a model or mesh [m, deg] (default: as in its file)",
    )
    parser.add_argument(
        "--scale",
        type=float,
        help="unit of a mesh file [m] (1)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Renders the capture."""
    _check(arguments)
    noise = sensor_noise(arguments.noise)
    check_writable(arguments.folder / TRANSFORMS)
    subject = _subject(arguments)
    poses = survey(
        subject.field,
        subject.focus,
        arguments.views,
        arguments.seed,
        subject.radius,
        min(CLEARANCE, CLEARANCE * subject.radius / RADIUS),
    )
    console = open_console(stderr=True)
    with Progress(console) as progress:
        capture = render_views(
            subject.solids,
            poses,
            arguments.width,
            arguments.height,
            on_view=partial(progress.report, "rendering"),
        )
        if arguments.noise != "none":
            progress.report("adding noise")
            capture = with_noise(capture, noise, arguments.seed)
        progress.report("writing")
        if subject.truth is not None:
            write_rmmi(arguments.folder / TRUTH, subject.truth)
        write_capture(arguments.folder, capture)
    open_console().print(f"{len(capture)} views in {arguments.folder}")
    return 0


def _check(arguments: argparse.Namespace):
    check_positive(
        "render-capture",
        arguments,
        *("views", "width", "height", "radius", "scale"),
    )
    check_seed("render-capture", arguments)
    check_finite("render-capture", arguments, "around", "place")
    if arguments.width * arguments.height > MAX_PIXELS:
        problem = (
            f"exceeds {MAX_PIXELS:,} pixels together with --height; reduce "
            "one of them"
        )
        raise FieldError("render-capture", "--width", problem)


def _subject(arguments: argparse.Namespace) -> _Subject:
    scene = _primitive_scene(arguments.scene)
    if scene is None:
        return _solid_subject(arguments)
    for name in ("place", "scale"):
        if getattr(arguments, name) is not None:
            problem = "has an effect only on models and meshes; leave it out"
            raise FieldError("render-capture", f"--{name}", problem)
    if arguments.around is not None:
        focus = np.array(arguments.around)
    elif scene.X_WE_target is not None:
        focus = scene.X_WE_target.translation()
    else:
        raise RemoSplatError(f"{scene.name} has no target: add --around X Y Z")
    if arguments.floor:
        scene = scene.with_floor()
    if not len(scene):
        raise RemoSplatError(f"{scene.name} is empty")
    return _Subject(
        primitive_solids(scene),
        SignedDistanceField(scene),
        focus,
        arguments.radius or RADIUS,
        scene,
    )


def _primitive_scene(name: str) -> PrimitiveScene | None:
    """Returns the scene of a generated family or an RMMI file; else None."""
    family, _, seed = name.partition(":")
    if seed.isdecimal() and family.isidentifier():
        return generate(family, int(seed))
    path = resolve(name)
    return read_scene(path) if path.suffix.lower() == ".json" else None


def _solid_subject(arguments: argparse.Namespace) -> _Subject:
    *p_WM, yaw = arguments.place or (0.0, 0.0, 0.0, 0.0)
    R_WM = RotationMatrix.MakeZRotation(np.deg2rad(yaw))
    X_WM = RigidTransform(R_WM, p_WM)
    solids = read_solids(resolve(arguments.scene), X_WM, arguments.scale or 1.0)
    lower, upper = extent(solids)
    middle, size = (lower + upper) / 2, float(np.linalg.norm(upper - lower))
    around = None if arguments.around is None else np.array(arguments.around)
    radius = arguments.radius or min(RADIUS, size)
    if arguments.floor:
        floor = PrimitiveScene().with_floor(
            center=(middle[0], middle[1]), half_extent=max(RADIUS, size)
        )
        solids = (*solids, *primitive_solids(floor))
    field = look_round(solids, lower, upper, around)
    focus = middle if around is None else around
    return _Subject(solids, field, focus, radius)
