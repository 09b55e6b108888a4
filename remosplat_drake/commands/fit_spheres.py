"""`remosplat fit-spheres`: covers a robot's links with spheres."""

import argparse
from pathlib import Path

from remosplat_drake.base import resources
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.progress import Progress
from remosplat_drake.base.table import Table
from remosplat_drake.commands.tables import open_console, print_table
from remosplat_drake.robot.fitting.covering import Covering, fit_covering
from remosplat_drake.robot.fitting.model_surfaces import SurfaceOptions
from remosplat_drake.robot.fitting.sphere_fitting import MOST_SPHERES
from remosplat_drake.robot.robot_description import load_robot_description

COUNT = 77
"""Default number of spheres."""

EXAMPLES = """
remosplat fit-spheres my_arm.urdf --output spheres.yaml
remosplat fit-spheres my_arm.urdf --tolerance 30
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the command's flags."""
    parser.add_argument(
        "model",
        metavar="MODEL",
        help=(
            "a URDF, SDF or *.dmd.yaml file, a robot description file, or "
            "the name of a shipped robot"
        ),
    )
    parser.add_argument(
        "--count", type=int, help=f"largest number of spheres ({COUNT})"
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="MM",
        help=(
            "instead of --count: largest distance by which spheres may "
            "protrude from a link [mm]. Links that need more than --most "
            "spheres exceed it"
        ),
    )
    parser.add_argument(
        "--most",
        type=int,
        metavar="N",
        help="with --tolerance: largest number of spheres per link"
        f" ({MOST_SPHERES})",
    )
    parser.add_argument(
        "--links", nargs="+", default=[], help="only these links (default all)"
    )
    parser.add_argument(
        "--weight",
        nargs="+",
        default=[],
        metavar="LINK=FACTOR",
        help=(
            "fit smaller spheres (factor > 1) or larger spheres (factor < 1) "
            "to a link"
        ),
    )
    parser.add_argument(
        "--meshes",
        action="store_true",
        help=(
            "cover the meshes that the robot description names (extra "
            "`meshes`) instead of the collision shapes"
        ),
    )
    parser.add_argument(
        "--with-collision",
        nargs="+",
        default=[],
        metavar="LINK",
        help="with --meshes: also cover the collision shapes of these links",
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--output", type=Path, help="YAML file to write (default: none)"
    )


def run(args: argparse.Namespace) -> int:
    """Fits the spheres, prints a table and writes the sphere model."""
    if args.count is not None and args.tolerance is not None:
        raise RemoSplatError("--tolerance: not with --count")
    tolerance, count = args.tolerance, args.count
    if tolerance is not None and not 0.5 <= tolerance <= 200:
        problem = f"expected 0.5 to 200 [mm], got {tolerance:g}"
        raise FieldError("fit-spheres", "--tolerance", problem)
    if tolerance is None and args.most is not None:
        problem = "needs --tolerance; without it, use --count"
        raise FieldError("fit-spheres", "--most", problem)
    if args.most is not None and not 1 <= args.most <= 200:
        problem = f"expected 1 to 200, got {args.most}"
        raise FieldError("fit-spheres", "--most", problem)
    if tolerance is None and count is None:
        count = COUNT
    model, options = _options(args)
    console = open_console()
    with Progress(console, "reading the surfaces") as progress:
        covering = fit_covering(
            model,
            options,
            count=count,
            tolerance=None if tolerance is None else 1e-3 * tolerance,
            most=args.most or MOST_SPHERES,
            seed=args.seed,
            on_progress=progress.report,
        )
    print_table(console, _table(covering))
    if args.output:
        text = covering.to_yaml(_comments(args, covering))
        write_atomically(args.output, text)
        console.print(f"wrote {args.output}")
    return 0


def _options(args: argparse.Namespace) -> tuple[Path, SurfaceOptions]:
    """Returns the model file, and the options that select the surfaces."""
    floor_links, visuals = (), None
    bare = args.model.endswith((".urdf", ".sdf", ".xml", ".dmd.yaml"))
    if bare:
        model = resources.resolve(args.model)
        if args.meshes:
            raise RemoSplatError(
                f"--meshes: {args.model} names no meshes; give a robot "
                "description file instead of a model file"
            )
    else:
        description = load_robot_description(args.model)
        model = description.model_path
        floor_links = tuple(description.floor_links)
        if args.meshes:
            visuals = description.visuals_path
    return model, SurfaceOptions(
        tuple(args.links),
        visuals,
        tuple(args.with_collision),
        tuple(x for x in floor_links if not args.links or x in args.links),
        dict(_weight(text) for text in args.weight),
    )


def _weight(text: str) -> tuple[str, float]:
    link, _, factor = text.partition("=")
    try:
        weight = float(factor)
    except ValueError:
        weight = 0.0
    if not 0.0 < weight < float("inf"):
        raise FieldError("--weight", text, "expected LINK=FACTOR, FACTOR > 0")
    return link, weight


def _table(covering: Covering) -> Table:
    return Table(
        f"{len(covering)} spheres; they contain all sampled surface points",
        ("link", "spheres", "mean bulge [mm]", "max bulge [mm]"),
        tuple(
            (
                link,
                str(len(fit.radius)),
                f"{1e3 * covering.bulges[link].mean:.1f}",
                f"{1e3 * covering.bulges[link].max:.1f}",
            )
            for link, fit in covering.fits.items()
        ),
    )


def _comments(args: argparse.Namespace, covering: Covering) -> list[str]:
    goal = f"--count {args.count or COUNT}"
    if args.tolerance is not None:
        goal = f"--tolerance {args.tolerance:g}"
        goal += f" --most {args.most}" if args.most else ""
    return [
        f"{len(covering)} spheres that cover the robot, made with",
        f"  remosplat fit-spheres {Path(args.model).name}"
        f" {goal} --seed {args.seed}" + (" --meshes" if args.meshes else ""),
        *(f"    --{x} {' '.join(v)}" for x, v in _lists(args) if v),
    ]


def _lists(args: argparse.Namespace) -> list[tuple[str, list[str]]]:
    return [
        ("links", args.links),
        ("with-collision", args.with_collision),
        ("weight", args.weight),
    ]
