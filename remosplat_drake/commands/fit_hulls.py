"""`remosplat fit-hulls`: makes convex collision shapes of a robot's meshes."""

import argparse
from pathlib import Path

from rich.table import Table

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FieldError, RemoSplatError, unknown_name
from remosplat_drake.commands.tables import open_console
from remosplat_drake.robot.fitting.convex_pieces import (
    ConvexPiece,
    convex_pieces,
)
from remosplat_drake.robot.fitting.model_surfaces import mesh_triangles
from remosplat_drake.robot.robot_description import load_robot_description
from remosplat_drake.robot.sphere_model import load_sphere_model
from remosplat_drake.robot.visuals import load_visuals

EXAMPLES = """
remosplat fit-hulls frankie --output collision
remosplat fit-hulls frankie --links panda_link7 --tolerance 2
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the command's flags."""
    parser.add_argument(
        "robot",
        metavar="ROBOT",
        help="name of a shipped robot, or a robot description file",
    )
    parser.add_argument(
        "--spheres",
        default="covering",
        help="name of the robot's sphere set; its spheres must enclose the "
        "meshes (covering)",
    )
    parser.add_argument(
        "--links", nargs="+", default=[], help="only these links (default all)"
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        default=1.0,
        metavar="MM",
        help=(
            "largest distance by which a mesh may extend beyond its convex "
            "shapes (1 mm)"
        ),
    )
    parser.add_argument(
        "--output",
        type=Path,
        help=(
            "folder for the shapes (.obj), and for URDF elements that refer "
            "to them"
        ),
    )


def run(args: argparse.Namespace) -> int:
    """Cuts the meshes into convex shapes, prints a table, writes the shapes."""
    if not 0.0 < args.tolerance < float("inf"):
        raise FieldError("--tolerance", str(args.tolerance), "expected > 0")
    description = load_robot_description(args.robot)
    spheres = load_sphere_model(description.spheres_path(args.spheres))
    path = description.visuals_path
    if path is None:
        raise FieldError(description.source, "visuals", "names no meshes")
    visuals = load_visuals(path)
    for link in args.links:
        if link not in visuals:
            raise RemoSplatError(unknown_name("link", link, visuals))
    console = open_console()
    shapes = {}
    for link in args.links or visuals:
        console.print(f"cutting {link}")
        try:
            shapes[link] = convex_pieces(
                mesh_triangles(visuals[link]),
                spheres.on_link(link),
                1e-3 * args.tolerance,
            )
        except RemoSplatError as error:
            raise RemoSplatError(f"{link}: {error}") from error
    console.print(_table(shapes))
    if args.output:
        _write(args.output, shapes)
        console.print(f"wrote {args.output}")
    return 0


def _table(shapes: dict[str, list[ConvexPiece]]) -> Table:
    table = Table(title="convex shapes; the robot's spheres enclose them")
    table.add_column("link")
    for name in ("shapes", "corners", "volume [l]"):
        table.add_column(name, justify="right")
    for link, pieces in shapes.items():
        table.add_row(
            link,
            str(len(pieces)),
            ", ".join(str(len(piece.vertices)) for piece in pieces),
            f"{1e3 * sum(piece.volume for piece in pieces):.3f}",
        )
    return table


def _write(folder: Path, shapes: dict[str, list[ConvexPiece]]) -> None:
    elements = [
        "<!-- Copy these elements into a URDF in the parent folder. -->"
    ]
    for link, pieces in shapes.items():
        elements.append(f'<link name="{link}">')
        for i, piece in enumerate(pieces):
            name = f"{link}_{i}.obj"
            write_atomically(folder / name, piece.to_obj(_COMMENT))
            elements.append(_ELEMENT.format(i, f"{folder.name}/{name}"))
        elements.append("</link>")
    write_atomically(folder / "shapes.xml", "\n".join(elements) + "\n")


_COMMENT = "A convex part of a link, made by `remosplat fit-hulls`."

_ELEMENT = """\
  <collision name="hull_{}">
    <geometry>
      <mesh filename="{}"><drake:declare_convex/></mesh>
    </geometry>
  </collision>"""
