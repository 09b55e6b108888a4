"""Scales a splat to metres and sets it upright; declares the flags for both."""

import argparse

import numpy as np
from pydrake.math import RigidTransform
from rich.console import Console

from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.commands.flags import (
    check_finite,
    check_positive,
    flag_name,
)
from remosplat_drake.commands.splat_guide import (
    add_guide_arguments,
    check_guide,
    guided,
    scaled_pose,
    turn_in_words,
    words_of_floor,
)
from remosplat_drake.reconstruction.splat_floor import (
    SplatFloor,
    find_splat_floor,
    frame_of_points,
)
from remosplat_drake.splat.gaussian_splat import (
    LARGEST_SCALE,
    LEAST_SCALE,
    GaussianSplat,
)

_FLOOR = "floor"

_FARTHEST = 1e9
"""Coordinates in flags may be at most this large, in any unit."""

_POINTS = ("X0", "Y0", "Z0", "X1", "Y1", "Z1")
_THIRD = ("X2", "Y2", "Z2")


def add_placement_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the flags for the splat's unit and frame."""
    group = parser.add_argument_group(
        "unit and frame",
        "All coordinates in these flags are coordinates of A, as a viewer of "
        "A shows them. The splat is cleaned, cropped, scaled, set upright "
        "and converted to surfels, in this order.",
    )
    scale = group.add_mutually_exclusive_group()
    scale.add_argument(
        "--scale", type=float, metavar="S", help="metres per unit of A"
    )
    scale.add_argument(
        "--scale-by",
        type=float,
        nargs=7,
        metavar=(*_POINTS, "LENGTH"),
        help="scale by two points and their true distance [m]",
    )
    align = group.add_mutually_exclusive_group()
    align.add_argument(
        "--align",
        choices=(_FLOOR,),
        help=(
            "find the floor, and set the splat upright: z is then up, and "
            "the floor is z = 0"
        ),
    )
    align.add_argument(
        "--align-points",
        type=float,
        nargs=9,
        metavar=(*_POINTS, *_THIRD),
        help="three points on the floor: the new origin, one along x, and one"
        " towards y; counterclockwise, seen from above",
    )
    group.add_argument(
        "--up",
        type=float,
        nargs=3,
        metavar=("X", "Y", "Z"),
        help=(
            "for --align floor: upward direction in A, with an error of at "
            "most 45 degrees; 0 -1 0 in many files from COLMAP, 0 1 0 in many "
            "files from phones (default: the side of the floor on which most "
            "of the splat lies)"
        ),
    )
    add_guide_arguments(group)


def check_placement(arguments: argparse.Namespace) -> None:
    """Checks the flags for unit and frame.

    Raises:
        FieldError: A number is infinite, NaN or too large; a scale or points
            are invalid; or `--up` is zero or has no effect.
    """
    check_guide(arguments)
    check_positive("convert", arguments, "scale")
    for name in ("scale_by", "align_points", "up"):
        check_finite("convert", arguments, name)
        if np.max(np.abs(getattr(arguments, name) or 0)) > _FARTHEST:
            problem = f"must be {_FARTHEST:g} at most"
            raise FieldError("convert", flag_name(name), problem)
    if arguments.up is not None:
        if arguments.align is None:
            problem = "has an effect only with --align floor; add --align floor"
            raise FieldError("convert", "--up", problem)
        if np.linalg.norm(arguments.up) < 1 / _FARTHEST:
            raise FieldError("convert", "--up", "must have a length > 0")
    _scale(arguments)
    _frame(arguments)


def find_placement(
    splat_G: GaussianSplat, arguments: argparse.Namespace, console: Console
) -> tuple[RigidTransform | None, float]:
    """Computes the pose and scale of a splat from the flags, and prints them.

    Args:
        splat_G: The splat, as read from its file.
        arguments: The command line.
        console: Console for the results.

    Returns:
        The pose X_FG of the splat's frame G in the new frame F (None if it does
        not change), and the metres per unit.

    Raises:
        RemoSplatError: No plane is clearly the floor.
    """
    if arguments.guide:
        return guided(splat_G, arguments.length, console)
    scale = _scale(arguments)
    if scale is not None:
        console.print(f"Scaled by {scale:.6g}: {_size(splat_G, scale)}.")
    scale = scale or 1.0
    X_FG = _frame(arguments)
    if arguments.align is not None:
        floor = _floor(splat_G, arguments.up)
        X_FG = scaled_pose(floor.X_FG, scale)
        console.print(words_of_floor(floor, X_FG))
    elif X_FG is not None:
        X_FG = scaled_pose(X_FG, scale)
        console.print(_words_of_points(splat_G, X_FG, scale))
    return X_FG, scale


def _scale(arguments: argparse.Namespace) -> float | None:
    """Returns the metres per unit, if the flags define it."""
    flag, scale = "--scale", arguments.scale
    if arguments.scale_by is not None:
        flag = "--scale-by"
        p, q = np.reshape(arguments.scale_by[:6], (2, 3))
        length, distance = arguments.scale_by[6], np.linalg.norm(q - p)
        if not distance:
            raise FieldError(
                "convert",
                flag,
                "the two points are equal; give two different points",
            )
        if not length > 0:
            raise FieldError("convert", flag, "LENGTH must be positive")
        scale = float(length / distance)
    if scale is not None and not LEAST_SCALE <= scale <= LARGEST_SCALE:
        problem = f"must lie in [{LEAST_SCALE:g}, {LARGEST_SCALE:g}]"
        raise FieldError("convert", flag, f"{problem}, got {scale:g}")
    return scale


def _frame(arguments: argparse.Namespace) -> RigidTransform | None:
    """Returns the frame that three given points define; None without them."""
    if arguments.align_points is None:
        return None
    try:
        return frame_of_points(*np.reshape(arguments.align_points, (3, 3)))
    except RemoSplatError as error:
        raise FieldError("convert", "--align-points", str(error)) from error


def _floor(splat_G: GaussianSplat, up_G: list[float] | None) -> SplatFloor:
    try:
        return find_splat_floor(
            splat_G, None if up_G is None else np.array(up_G)
        )
    except RemoSplatError as error:
        problem = (
            f"{error}; give an approximate upward direction by --up X Y Z, or "
            "three points on the floor by --align-points"
        )
        raise FieldError("convert", "--align", problem) from error


def _words_of_points(
    splat_G: GaussianSplat, X_FG: RigidTransform, scale: float
) -> str:
    z_F = splat_G.p_GK @ (scale * X_FG.rotation().matrix()[2])
    above = float((z_F + X_FG.translation()[2] > 0).mean())
    words = (
        f"{turn_in_words(X_FG)}, so that the three points lie on the floor; z "
        f"is up, and the first point is the origin. {100 * above:.0f} % of "
        "the splats are above the floor."
    )
    if above < 0.5:
        words += (
            " The points may be in clockwise order, seen from above: "
            "exchange two."
        )
    return words


def _size(splat: GaussianSplat, scale: float) -> str:
    """Describes the size of the scaled splat, without its outliers."""
    lower, upper = np.quantile(splat.p_GK, (0.02, 0.98), axis=0)
    sides = " x ".join(f"{side:.2f}" for side in scale * (upper - lower))
    return f"96 % of the splats now lie within {sides} m along the input's axes"
