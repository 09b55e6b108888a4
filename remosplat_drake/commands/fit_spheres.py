"""`remosplat fit-spheres`: cover any robot with a few spheres."""

import argparse
from pathlib import Path

from rich.progress import Progress

from remosplat_drake.base import resources
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.table import Table
from remosplat_drake.commands.tables import open_console, print_table
from remosplat_drake.robot.fitting.link_spheres import (
    Bulge,
    LinkSpheres,
    measure_bulge,
)
from remosplat_drake.robot.fitting.model_surfaces import (
    SurfaceOptions,
    model_surfaces,
)
from remosplat_drake.robot.fitting.sphere_fitting import fit_spheres
from remosplat_drake.robot.robot_description import load_robot_description

EXAMPLES = """
remosplat fit-spheres my_arm.urdf --output spheres.yaml
"""
"""What `--help` ends with."""


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the command's flags."""
    parser.add_argument(
        "model",
        metavar="MODEL",
        help="a URDF, SDF or *.dmd.yaml file, a robot's description file or"
        " the name of a shipped robot",
    )
    parser.add_argument(
        "--count", type=int, default=77, help="how many spheres at most (77)"
    )
    parser.add_argument(
        "--links", nargs="+", default=[], help="only these links (default all)"
    )
    parser.add_argument(
        "--weight",
        nargs="+",
        default=[],
        metavar="LINK=FACTOR",
        help="give a link slimmer (> 1) or coarser (< 1) spheres",
    )
    parser.add_argument(
        "--meshes",
        action="store_true",
        help="fit to the meshes of the robot's description (extra `meshes`)"
        " instead of to its collision shapes",
    )
    parser.add_argument(
        "--with-collision",
        nargs="+",
        default=[],
        metavar="LINK",
        help="with --meshes: cover the collision shapes of these links too",
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--output", type=Path, help="YAML file to write (default: none)"
    )


def run(args: argparse.Namespace) -> int:
    """Fits the spheres, prints a table and writes the sphere model."""
    model, options = _options(args)
    console = open_console()
    with Progress(console=console, transient=True) as progress:
        task = progress.add_task("reading the surfaces", total=None)
        surfaces = model_surfaces(model, options, args.seed)
        progress.update(task, description="fitting", total=len(surfaces))
        fits = fit_spheres(
            surfaces,
            args.count,
            args.seed,
            on_progress=lambda link, spheres: progress.advance(task),
        )
        # Points that the fit has not seen find the slits between spheres.
        progress.update(task, description="checking with fresh points")
        fresh = model_surfaces(model, options, args.seed + 1)
        fits = {
            link: fit.grown_over(fresh[link].points, 5e-4)
            for link, fit in fits.items()
        }
    bulges = {
        link: measure_bulge(fit, surfaces[link].solid)
        for link, fit in fits.items()
    }
    print_table(console, _table(fits, bulges))
    if args.output:
        write_atomically(args.output, _to_yaml(args, fits, bulges))
        console.print(f"wrote {args.output}")
    return 0


def _options(args: argparse.Namespace) -> tuple[Path, SurfaceOptions]:
    """Tells a robot description from a bare model file."""
    floor_links, visuals = (), None
    bare = args.model.endswith((".urdf", ".sdf", ".xml", ".dmd.yaml"))
    if bare:
        model = resources.resolve(args.model)
        if args.meshes:
            raise RemoSplatError(
                f"--meshes: {args.model} names no meshes; give the robot's"
                " description instead of its model file"
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


def _table(fits: dict[str, LinkSpheres], bulges: dict[str, Bulge]) -> Table:
    return Table(
        f"{_total(fits)} spheres; all surface points inside",
        ("link", "spheres", "mean bulge [mm]", "max bulge [mm]"),
        tuple(
            (
                link,
                str(len(fit.radius)),
                f"{1e3 * bulges[link].mean:.1f}",
                f"{1e3 * bulges[link].max:.1f}",
            )
            for link, fit in fits.items()
        ),
    )


def _to_yaml(
    args: argparse.Namespace,
    fits: dict[str, LinkSpheres],
    bulges: dict[str, Bulge],
) -> str:
    """Writes the sphere model in tenths of a millimetre, radii rounded up."""
    lines = [
        f"# {_total(fits)} spheres that cover the robot, made with",
        f"#   remosplat fit-spheres {Path(args.model).name}"
        f" --count {args.count} --seed {args.seed}"
        + (" --meshes" if args.meshes else ""),
        *(f"#     --{x} {' '.join(v)}" for x, v in _lists(args) if v),
        "# How far they stand out of each link, mean and largest [mm]:",
        *(
            f"#   {link}: {1e3 * bulge.mean:.1f}, {1e3 * bulge.max:.1f}"
            for link, bulge in bulges.items()
        ),
        "# link: [x, y, z, radius] in the link frame [m].",
        "spheres:",
    ]
    for link, fit in fits.items():
        lines.append(f"  {link}:")
        for p_LS, radius in zip(fit.p_LS, fit.radius, strict=True):
            # Rounding moves a centre by less than 0.1 mm.
            row = [*p_LS.round(4) + 0.0, round(radius + 1e-4, 4)]
            lines.append(f"  - [{', '.join(f'{x:g}' for x in row)}]")
    return "\n".join(lines) + "\n"


def _lists(args: argparse.Namespace) -> list[tuple[str, list[str]]]:
    return [
        ("links", args.links),
        ("with-collision", args.with_collision),
        ("weight", args.weight),
    ]


def _total(fits: dict[str, LinkSpheres]) -> int:
    return sum(len(fit.radius) for fit in fits.values())
