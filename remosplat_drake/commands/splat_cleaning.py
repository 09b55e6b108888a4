"""Removes junk from a splat; declares the flags of this removal."""

import argparse
from pathlib import Path

from rich.console import Console

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.progress import Progress
from remosplat_drake.commands.tables import print_table
from remosplat_drake.splat.cleaning.junk import Junk, find_junk
from remosplat_drake.splat.cleaning.junk_page import UNBOUNDED, junk_table
from remosplat_drake.splat.cleaning.views import (
    TRANSFORMS,
    Views,
    read_views,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_LEAST_SEEN = 0.5
"""A splat's cameras must see at least this fraction of its Gaussians. Cameras
that see fewer probably belong to another splat or frame."""


def add_cleaning_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the flags that remove junk."""
    group = parser.add_argument_group(
        "cleaning",
        "Splats from other programs contain Gaussians that do not represent "
        "surfaces (junk). With --clean, the command removes junk before all "
        "other steps, and writes B.clean.html, a page that shows the junk. It "
        "keeps large groups of connected splats, except nearly transparent "
        "and far too large splats in them.",
    )
    group.add_argument(
        "--clean",
        action="store_true",
        help=(
            "remove junk: faint, giant and needle-shaped splats, sky, and "
            "floaters"
        ),
    )
    group.add_argument(
        "--views",
        type=Path,
        metavar="TRANSFORMS",
        help=(
            "with --clean: the cameras of the training, as a transforms.json "
            f"in A's coordinates (default: {TRANSFORMS} beside A, if its "
            "cameras see the splat)"
        ),
    )


def check_cleaning(arguments: argparse.Namespace) -> None:
    """Checks the flags for cleaning.

    Raises:
        FieldError: `--views` is given without `--clean`.
    """
    if arguments.views is not None and not arguments.clean:
        problem = "has an effect only with --clean; add --clean"
        raise FieldError("convert", "--views", problem)


def cleaned(
    splat: GaussianSplat,
    arguments: argparse.Namespace,
    source: Path,
    console: Console,
) -> tuple[GaussianSplat, Junk]:
    """Removes junk from a splat, and prints the count of each kind of junk.

    Args:
        splat: The splat, as read from its file.
        arguments: The command line.
        source: The splat's file.
        console: Console for the results.

    Returns:
        The remaining splat, and the removed part.

    Raises:
        RemoSplatError: The cameras are unusable, or all of the splat was
            removed.
    """
    views = _views(splat, arguments, source, console)
    with Progress(console) as progress:
        junk = find_junk(splat, views, progress.report)
    if not junk.is_kept.any():
        raise FieldError("convert", "--clean", "leaves no splats")
    print_table(console, junk_table(junk))
    console.print(UNBOUNDED)
    return splat.select(junk.is_kept), junk


def _views(
    splat: GaussianSplat,
    arguments: argparse.Namespace,
    source: Path,
    console: Console,
) -> Views | None:
    """Reads the cameras from the file of `--views`, or beside the splat."""
    beside = source.parent / TRANSFORMS
    path = arguments.views or (beside if beside.is_file() else None)
    if path is None:
        return None
    views = read_views(path)
    seen = views.seen_share(splat.p_GK)
    if seen >= _LEAST_SEEN:
        console.print(
            f"{path}: {len(views)} cameras show which space was seen."
        )
        return views
    problem = (
        f"its cameras see only {100 * seen:.0f} % of the splats; check whether"
        " the file has another frame or unit"
    )
    if arguments.views is not None:
        raise FileError(path, problem)
    console.print(f"{path}: not used: {problem}")
    return None
