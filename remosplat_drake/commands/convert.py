"""`remosplat convert`: converts a splat to another file format."""

import argparse
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.resources import resolve
from remosplat_drake.commands.splat_cleaning import (
    add_cleaning_arguments,
    check_cleaning,
    cleaned,
)
from remosplat_drake.commands.splat_placement import (
    add_placement_arguments,
    check_placement,
    find_placement,
)
from remosplat_drake.commands.tables import open_console
from remosplat_drake.splat.cleaning.junk_page import junk_page, page_path
from remosplat_drake.splat.codecs.conversion_error import conversion_error
from remosplat_drake.splat.formats import (
    FORMATS,
    format_of_file,
    format_of_name,
    read_splat,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_conversion import THICKNESS, flattened

_MODELS = {"2dgs": True, "3dgs": False}

EXAMPLES = """
remosplat convert kitchen.ply kitchen.sog --crop -2 -2 0 2 2 2
remosplat convert phone.ply kitchen.ply --scale 0.37 --align floor --up 0 1 0
remosplat convert phone.ply kitchen.ply --clean --guide --length 4.2
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    suffixes = ", ".join(sorted(f.suffix for f in FORMATS))
    parser.add_argument(
        "source",
        metavar="A",
        help=(f"the splat to convert: {suffixes}, or a folder of SOG"),
    )
    parser.add_argument(
        "output",
        metavar="B",
        type=Path,
        help="the file to write; its suffix determines the format",
    )
    parser.add_argument(
        "--surfels",
        action="store_true",
        help="convert each ellipsoid to a disc whose normal is the ellipsoid's "
        "shortest axis",
    )
    parser.add_argument(
        "--crop",
        type=float,
        nargs=6,
        metavar=("X0", "Y0", "Z0", "X1", "Y1", "Z1"),
        help=(
            "keep only splats inside the axis-aligned box with these two "
            "corners, in A's coordinates"
        ),
    )
    parser.add_argument(
        "--model",
        choices=_MODELS,
        help=(
            "kind of splats in a checkpoint; needed if the checkpoint's file "
            "name does not contain the kind"
        ),
    )
    add_cleaning_arguments(parser)
    add_placement_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Converts the file, and prints the steps and the loss of precision."""
    check_cleaning(arguments)
    check_placement(arguments)
    target = format_of_name(arguments.output)
    source = resolve(arguments.source)
    splat = read_splat(source, _MODELS.get(arguments.model))
    console = open_console(highlight=False, soft_wrap=True)
    title = format_of_file(source).title
    console.print(f"{source}: {title}, {_description(splat)}")
    whole, junk = splat, None
    if arguments.clean:
        splat, junk = cleaned(splat, arguments, source, console)
    if arguments.crop is not None:
        splat = _cropped(splat, arguments.crop)
    X_FG, scale = find_placement(splat, arguments, console)
    if X_FG is not None or scale != 1:
        splat = splat.transformed(X_FG or RigidTransform(), scale)
    if arguments.surfels:
        splat = flattened(splat)
    target.write(arguments.output, splat)
    if junk is not None:
        page = page_path(arguments.output)
        p_FK = scale * whole.p_GK.astype(float)
        if X_FG is not None:
            p_FK = X_FG.multiply(p_FK.T).T
        name = arguments.output.name
        write_atomically(page, junk_page(junk, p_FK, name, X_FG is not None))
        console.print(f"{page}: shows the removed splats from two sides")
    console.print(f"{arguments.output}: {target.title}, {_description(splat)}")
    if splat.is_surfel and not target.keeps_surfels:
        console.print(
            "This format stores the discs as ellipsoids "
            f"{1e6 * THICKNESS:.0f} um thick; this program reads them as "
            "discs again."
        )
    if splat.uncertainty is not None and not target.keeps_uncertainty:
        largest = f"{1e3 * splat.uncertainty.max():.1f} mm"
        console.print(
            f"The splats' uncertainty, up to {largest}, is lost: "
            f"{target.title} cannot store it, so oracles will not subtract it "
            "from distances."
        )
    if target.loss:
        again = read_splat(arguments.output)
        console.print(f"Lossy. {target.loss}")
        console.print(_measured_loss(target.as_written(splat), again))
    return 0


def _cropped(splat: GaussianSplat, corners: list[float]) -> GaussianSplat:
    lower, upper = np.array(corners[:3]), np.array(corners[3:])
    splat = splat.cropped(lower, upper)
    if not len(splat):
        raise FieldError("convert", "--crop", "leaves no splats")
    return splat


def _description(splat: GaussianSplat) -> str:
    model = "2DGS discs" if splat.is_surfel else "3DGS ellipsoids"
    bands = round(np.sqrt(splat.sh_rest.shape[1] + 1)) - 1
    text = f"{len(splat)} {model}, colours of degree {bands}"
    if splat.uncertainty is not None:
        text += f", uncertain by up to {1e3 * splat.uncertainty.max():.1f} mm"
    return text


def _measured_loss(before: GaussianSplat, after: GaussianSplat) -> str:
    """Returns a line on the differences between splat and written file."""
    error = conversion_error(before, after)
    parts = {
        "position": (1e3 * error.position, "mm"),
        "scale": (1e2 * error.scale, "%"),
        "rotation": (np.degrees(error.rotation), "deg"),
        "opacity": (error.opacity, ""),
    }
    return "Measured, median and largest: " + "; ".join(
        f"{name} {_short(np.median(values))} and"
        f" {_short(values.max())} {unit}".strip()
        for name, (values, unit) in parts.items()
    )


def _short(value: float) -> str:
    return f"{round(value, 4):.3g}"
