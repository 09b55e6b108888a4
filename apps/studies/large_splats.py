"""Measures time and memory for splats of a building's size, step by step.

Each size is a seeded hall, see `hall_scene`, whose PLY is written to a
temporary folder and deleted at the end. Each size has a separate process, so
that its memory peak is known.
"""

import argparse
import multiprocessing as mp
import os
import resource
import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np
from pydrake.systems.analysis import Simulator
from rich.console import Console

from apps.studies.command_line import output_folder, study_main
from remosplat_drake.app.diagram import build
from remosplat_drake.app.warm_up import compile_kernels
from remosplat_drake.app.world import load_world
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.kernels.files import kernels_dir
from remosplat_drake.base.table import Table
from remosplat_drake.commands.splat_scenario import load_given
from remosplat_drake.commands.tables import open_console, print_table
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.splat.formats import read_splat, write_splat
from remosplat_drake.splat.hierarchy_cache import cache_folder
from remosplat_drake.timing.hall_scene import hall_scene
from remosplat_drake.timing.oracle_cases import MAX_DISTANCE, robot_spheres

COLUMNS = (
    "million splats",
    "write [s]",
    "read [s]",
    "build [s]",
    "query [ms]",
    "first tick [ms]",
    "run, until it moves [s]",
    "peak, read and built [GB]",
    "peak, run [GB]",
)
"""Columns of the table: the measurements of each size."""

_QUERIES = 200
"""Number of queries whose median is shown."""

_MOST = 100.0
"""Largest number of splats that is tried [millions]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "--millions",
        type=float,
        nargs="+",
        default=[1.0, 10.0, 30.0],
        metavar="M",
        help="numbers of splats, in millions (default: 1 10 30)",
    )
    parser.add_argument(
        "--folder",
        type=output_folder,
        metavar="DIR",
        help="folder for the temporary files; 64 MB per million splats"
        " (default: the system's folder for temporary files)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Measures each size, and prints the table."""
    for size in arguments.millions:
        if not 0.001 <= size <= _MOST:
            problem = f"must lie in [0.001, {_MOST:g}], got {size:g}"
            raise FieldError("large_splats", "--millions", problem)
    console, rows = open_console(), []
    with TemporaryDirectory(dir=arguments.folder) as folder:
        # Later runs can use the kernels, but not the hierarchies of these
        # splats.
        os.environ["NUMBA_CACHE_DIR"] = str(kernels_dir())
        os.environ["XDG_CACHE_HOME"] = folder
        path = Path(folder) / "hall.ply"
        for size in arguments.millions:
            (write,) = _alone(_written, path, round(1e6 * size))
            *steps, first_peak = _alone(_opened, path)
            *ticks, peak = _alone(_ticked, path)
            values = (size, write, *steps, *ticks, first_peak, peak)
            rows.append(tuple(f"{value:.3g}" for value in values))
            path.unlink()
    print_table(console, Table("Large splats", COLUMNS, tuple(rows)))
    return 0


def _alone(function: Callable[..., list[float]], *arguments) -> list[float]:
    """Calls a function in a separate process."""
    with mp.get_context("spawn").Pool(1) as pool:
        return pool.apply(function, arguments)


def _peak() -> float:
    """The largest memory that this process has had [GB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


def _written(path: Path, n: int) -> list[float]:
    """Time to write the file [s]."""
    splat = hall_scene(n)
    start = perf_counter()
    write_splat(path, splat)
    return [perf_counter() - start]


def _opened(path: Path) -> list[float]:
    """Times to read and build [s], of a query [ms], and peak memory [GB]."""
    shutil.rmtree(cache_folder(), ignore_errors=True)
    start = perf_counter()
    splat = read_splat(path, harmonics=False)
    read = perf_counter()
    field = SphereToEllipsoidField(splat)
    built, spheres, times = perf_counter(), robot_spheres(), []
    for _ in range(_QUERIES):
        before = perf_counter()
        field.clearances(spheres, MAX_DISTANCE)
        times.append(perf_counter() - before)
    query = 1e3 * float(np.median(times))
    return [read - start, built - read, query, _peak()]


def _ticked(path: Path) -> list[float]:
    """First tick of a scenario [ms], time until it [s], and peak memory [GB].

    It does the same as `remosplat run SPLAT.ply --headless`, with compiled
    kernels.
    """
    shutil.rmtree(cache_folder(), ignore_errors=True)
    start = perf_counter()
    scenario = load_given(str(path), "", Console(stderr=True))
    world = load_world(scenario)
    prepared = perf_counter() - start
    compile_kernels(scenario, world)
    simulator = Simulator(build(scenario, world).diagram)
    start = perf_counter()
    simulator.Initialize()
    simulator.AdvanceTo(scenario.control_period)
    tick = perf_counter() - start
    return [1e3 * tick, prepared, _peak()]


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study; returns its exit code."""
    return study_main("large_splats", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
