"""`remosplat convert --guide`: finds upward direction, floor and scale."""

import argparse

import numpy as np
from pydrake.math import RigidTransform
from rich.console import Console

from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.commands.flags import check_positive, flag_name
from remosplat_drake.reconstruction.splat_floor import (
    SplatFloor,
    find_splat_floor,
)
from remosplat_drake.splat.gaussian_splat import (
    LARGEST_SCALE,
    LEAST_SCALE,
    GaussianSplat,
)

_OUTSIDE = 0.02
"""When a side is measured, this fraction of the splats at each of its ends
counts as outliers and is ignored."""

_DIRECTIONS = 90
"""Number of horizontal directions in which the scene's width is measured."""

_SAME = np.cos(np.deg2rad(15.0))
"""Two directions count as equal if the cosine of their angle exceeds this."""


def add_guide_arguments(group: argparse._ArgumentGroup) -> None:
    """Declares the flags of the guide."""
    group.add_argument(
        "--guide",
        action="store_true",
        help="find the upward direction and the floor automatically, set the "
        "splat upright, and print the flags that have the same effect",
    )
    group.add_argument(
        "--length",
        type=float,
        metavar="L",
        help="true length of the scene's longest side along the floor [m], "
        "from which --guide computes the scale",
    )


def check_guide(arguments: argparse.Namespace) -> None:
    """Checks the flags `--guide` and `--length`.

    Raises:
        FieldError: A flag sets a value that `--guide` finds; or `--length` is
            given without `--guide`, or is not positive.
    """
    if arguments.length is not None and not arguments.guide:
        problem = "has an effect only with --guide; add --guide"
        raise FieldError("convert", "--length", problem)
    for name in ("scale", "scale_by", "align", "align_points", "up"):
        if arguments.guide and getattr(arguments, name) is not None:
            problem = (
                "finds this value itself; use either --guide or "
                f"{flag_name(name)}"
            )
            raise FieldError("convert", "--guide", problem)
    check_positive("convert", arguments, "length")


def guided(
    splat_G: GaussianSplat, length: float | None, console: Console
) -> tuple[RigidTransform, float]:
    """Finds upward direction, floor and scale, and prints equivalent flags.

    Args:
        splat_G: The splat, as read from its file.
        length: True length of the scene's longest side along the floor [m].
            None if it was not measured; the unit of the splat is then not
            changed.
        console: Console for the results.

    Returns:
        The pose X_FG of the splat's frame G in the floor's frame F [m], and the
        metres per unit.

    Raises:
        FieldError: No floor is found, or the scale is out of range.
    """
    floor, others = _best_floor(splat_G)
    side = _longest_side(splat_G, floor)
    scale = 1.0 if length is None else length / side
    if not LEAST_SCALE <= scale <= LARGEST_SCALE:
        problem = f"would scale by {scale:g}; valid: {LEAST_SCALE:g} to"
        raise FieldError("convert", "--length", f"{problem} {LARGEST_SCALE:g}")
    X_FG = scaled_pose(floor.X_FG, scale)
    console.print(words_of_floor(floor, X_FG))
    for up_G in others:
        console.print(
            "If this is not the floor, another plane may be; to use that "
            f"plane, give --up {_numbers(up_G)}."
        )
    flags = f"--align floor --up {_numbers(_up(floor))}"
    if length is None:
        console.print(
            f"The longest side along the floor is {side:.4g} units of A long. "
            "The length of a unit is unknown: give the true length of this "
            "side in metres by --length. Without it, a unit counts as a "
            "metre."
        )
    else:
        flags += f" --scale {scale:.6g}"
        console.print(
            f"The longest side along the floor, {side:.4g} units of A, is"
            f" {length:g} m: scaled by {scale:.6g}."
        )
    console.print(f"Flags with the same effect as --guide: {flags}")
    return X_FG, scale


def _best_floor(
    splat_G: GaussianSplat,
) -> tuple[SplatFloor, list[np.ndarray]]:
    """Returns the best floor, and the upward directions of other candidates.

    If no plane is clearly the floor, the function tries each axis as the upward
    direction.
    """
    try:
        return find_splat_floor(splat_G), []
    except RemoSplatError as error:
        problem = str(error)
    floors: list[SplatFloor] = []
    for up_G in (*np.eye(3), *-np.eye(3)):
        try:
            floor = find_splat_floor(splat_G, up_G)
        except RemoSplatError:
            continue
        if all(_up(floor) @ _up(other) < _SAME for other in floors):
            floors.append(floor)
    if not floors:
        raise FieldError(
            "convert",
            "--guide",
            f"{problem}; --align-points defines the floor by three points",
        )
    floors.sort(key=lambda floor: floor.beneath - floor.share)
    return floors[0], [_up(floor) for floor in floors[1:]]


def _up(floor: SplatFloor) -> np.ndarray:
    """Returns the upward direction in G that a floor defines."""
    return floor.X_FG.rotation().matrix()[2]


def _longest_side(splat_G: GaussianSplat, floor: SplatFloor) -> float:
    """Returns a splat's largest width along the floor, in its own unit."""
    p_F = splat_G.p_GK @ floor.X_FG.rotation().matrix()[:2].T
    angles = np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    ends = (
        np.quantile(
            p_F @ [np.cos(angle), np.sin(angle)], (_OUTSIDE, 1 - _OUTSIDE)
        )
        for angle in angles
    )
    return float(max(upper - lower for lower, upper in ends))


def _numbers(values: np.ndarray) -> str:
    return " ".join(f"{value:.4f}" for value in values)


def words_of_floor(floor: SplatFloor, X_FG: RigidTransform) -> str:
    """Describes the floor, and the motion that places the splat on it."""
    height = X_FG.translation()[2]
    return (
        f"Floor: {100 * floor.share:.0f} % of the splat's surface, with"
        f" {100 * floor.beneath:.1f} % beneath it. {turn_in_words(X_FG)}, and "
        f"moved by {height:.3f} m in height; z is up, and the floor z = 0."
    )


def scaled_pose(X_FG: RigidTransform, scale: float) -> RigidTransform:
    """Converts a pose's translation from a splat's unit to metres."""
    return RigidTransform(X_FG.rotation(), scale * X_FG.translation())


def turn_in_words(X_FG: RigidTransform) -> str:
    """Describes the rotation of the input's z axis."""
    tilt = np.arccos(np.clip(X_FG.rotation().matrix()[2, 2], -1, 1))
    return f"The input's z axis is turned by {np.degrees(tilt):.1f} degrees"
