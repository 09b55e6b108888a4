"""Compares the CPU and the CUDA backend of the depth views.

It queries both at random robot states, counts the views whose distances differ
by more than a millimetre, finds the reasons (see `differences`), and times the
queries.
"""

import argparse
import dataclasses as dc
import json
import os
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import perf_counter

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from apps.studies.command_line import output_file, study_main
from apps.studies.depth_backends.differences import (
    CLASSES,
    TOLERANCE,
    Differences,
    by_view,
)
from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.errors import FileError
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_rasterization_gsplat import GsplatDepthField
from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.splat.formats import read_splat
from remosplat_drake.splat.gaussian_splat import GaussianSplat

MAX_DISTANCE = 0.5
"""Influence distance of the controller, the range of queries [m]."""

_ARRAYS = ("p_WS", "R_WL", "radius", "ignore_below")


@dc.dataclass
class Comparison:
    """Agreement of the two backends over all states on one splat.

    Attributes:
        splat: Name of the splat.
        n_splats: Number of the splat's discs.
        states: Number of robot states.
        views: Number of views: six of each sphere in each state.
        answered: Number of views with a surface within `MAX_DISTANCE`.
        differ: Number of views whose distances differ by more than
            `TOLERANCE`.
        classes: Number of differing views by the reason, one of `CLASSES`.
        median_difference: Median absolute difference over all answered views
            [m].
        p99_difference: 99th percentile of the absolute difference over all
            answered views [m].
        farther: Largest excess of CUDA's distance over the CPU's [m].
        nearer: Largest excess of the CPU's distance over CUDA's [m].
        sphere_farther: Largest excess of a sphere's smallest distance by CUDA
            over the CPU's, where the sphere touches nothing [m].
        cpu_ms: Median and 99th percentile of the CPU's query time [ms].
        cuda_ms: Median and 99th percentile of CUDA's query time [ms].
    """

    splat: str
    n_splats: int
    states: int
    views: int
    answered: int
    differ: int
    classes: dict[str, int]
    median_difference: float
    p99_difference: float
    farther: float
    nearer: float
    sphere_farther: float
    cpu_ms: tuple[float, float]
    cuda_ms: tuple[float, float]


def compare(
    name: str, splat_W: GaussianSplat, states: Sequence[Spheres], threads: int
) -> Comparison:
    """Queries both backends at all states and classifies the differences.

    Args:
        name: Name of the splat in the table.
        splat_W: The splat, expressed in W.
        states: Spheres of the robot in each state.
        threads: Number of CPU threads.
    """
    sensor = DepthSensor()
    cpu = DepthRasterizationField(splat_W, sensor, num_threads=threads)
    cuda = GsplatDepthField(splat_W, sensor)
    differences = Differences(splat_W, sensor, MAX_DISTANCE)
    classes = dict.fromkeys(CLASSES, 0)
    signed, times = [], {"cpu": [], "cuda": []}
    sphere_farther = 0.0
    for field in (cpu, cuda):
        field.clearances(states[0], MAX_DISTANCE)
    for spheres in track(
        states, name, console=Console(stderr=True), transient=True
    ):
        answers = [
            by_view(_timed(field, spheres, times[key]), spheres, sensor)
            for key, field in (("cpu", cpu), ("cuda", cuda))
        ]
        a, b = (np.minimum(x.distance, MAX_DISTANCE) for x in answers)
        signed.append((b - a)[np.minimum(a, b) < MAX_DISTANCE])
        nearest, farther = a.min(axis=1), b.min(axis=1) - a.min(axis=1)
        sphere_farther = max(
            sphere_farther, float(farther[nearest > 0].max(initial=0.0))
        )
        reasons = Counter(
            differences.why(spheres, int(sphere), int(view), *answers)
            for sphere, view in np.argwhere(np.abs(b - a) > TOLERANCE)
        )
        for reason, count in reasons.items():
            classes[reason] += count
    error = np.concatenate(signed)
    return Comparison(
        splat=name,
        n_splats=len(splat_W),
        states=len(states),
        views=6 * sum(map(len, states)),
        answered=len(error),
        differ=sum(classes.values()),
        classes=classes,
        median_difference=float(np.median(np.abs(error))),
        p99_difference=float(np.percentile(np.abs(error), 99)),
        farther=float(error.max(initial=0.0)),
        nearer=float(-error.min(initial=0.0)),
        sphere_farther=sphere_farther,
        cpu_ms=_percentiles(times["cpu"]),
        cuda_ms=_percentiles(times["cuda"]),
    )


def _timed(
    field: DistanceField, spheres: Spheres, times: list[float]
) -> Clearances:
    start = perf_counter()
    answer = field.clearances(spheres, MAX_DISTANCE)
    times.append(1e3 * (perf_counter() - start))
    return answer


def _percentiles(times: list[float]) -> tuple[float, float]:
    return float(np.median(times)), float(np.percentile(times, 99))


def random_states(count: int, seed: int) -> Iterator[Spheres]:
    """Yields Frankie's spheres in random states before and in the scene."""
    from apps.studies.robot_states import BASE_LOWER, BASE_UPPER
    from remosplat_drake.robot.robot_model import load_robot

    robot = load_robot("frankie", floor_height=0.03)
    rng = np.random.default_rng(seed)
    lower, upper = robot.position_lower.copy(), robot.position_upper.copy()
    lower[:3], upper[:3] = BASE_LOWER, BASE_UPPER
    for _ in range(count):
        yield robot.spheres_at(rng.uniform(lower, upper))


def write_states(path: Path, states: Sequence[Spheres]) -> None:
    """Writes the spheres of states, for a machine without the robot model."""
    arrays = {
        name: np.array([getattr(s, name) for s in states], np.float32)
        for name in _ARRAYS
    }
    with atomic_write(path, "wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)


def read_states(path: Path) -> list[Spheres]:
    """Reads the spheres of states that `write_states` has written.

    Raises:
        FileError: The file cannot be read or does not hold such states.
    """
    try:
        with np.load(path) as file:
            arrays = [file[name].astype(float) for name in _ARRAYS]
    except (OSError, ValueError, KeyError) as error:
        raise FileError(path, "is not a file of --write-states") from error
    return [Spheres(*each) for each in zip(*arrays, strict=True)]


def print_table(comparisons: Sequence[Comparison]) -> None:
    """Prints a table with one row per splat."""
    table = Table(title=f"views that differ by > {1e3 * TOLERANCE:.0f} mm")
    columns = ["splat", "answered", "differ", *CLASSES]
    columns += ["p99 mm", "farther mm", "free mm", "cpu ms", "cuda ms"]
    for column in columns:
        table.add_column(column, justify="right")
    for c in comparisons:
        table.add_row(
            c.splat,
            str(c.answered),
            f"{100 * c.differ / max(c.answered, 1):.2f} %",
            *(str(count) for count in c.classes.values()),
            f"{1e3 * c.p99_difference:.2f}",
            f"{1e3 * c.farther:.1f}",
            f"{1e3 * c.sphere_farther:.1f}",
            "{:.2f}/{:.2f}".format(*c.cpu_ms),
            "{:.2f}/{:.2f}".format(*c.cuda_ms),
        )
    Console(width=160).print(table)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument("splats", nargs="*", type=Path, metavar="SPLAT.ply")
    parser.add_argument("--count", type=int, default=1000, help="robot states")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--states", type=Path, metavar="FILE", help="file of states to use"
    )
    parser.add_argument(
        "--write-states",
        type=output_file,
        metavar="FILE",
        help="file that receives the states",
    )
    parser.add_argument(
        "--threads",
        type=int,
        default=os.cpu_count(),
        help="number of threads of the CPU backend",
    )
    parser.add_argument(
        "--json",
        type=output_file,
        metavar="FILE",
        help="JSON file for the numbers",
    )


def run(arguments: argparse.Namespace) -> int:
    """Compares the backends on every splat and prints one table."""
    states = (
        read_states(arguments.states)[: arguments.count]
        if arguments.states
        else list(random_states(arguments.count, arguments.seed))
    )
    if arguments.write_states:
        write_states(arguments.write_states, states)
    comparisons = []
    for path in arguments.splats:
        name = path.stem if path.stem != "splat" else path.parent.name
        comparisons.append(
            compare(name, read_splat(path), states, arguments.threads)
        )
    print_table(comparisons)
    if arguments.json:
        with atomic_write(arguments.json) as file:
            json.dump([dc.asdict(c) for c in comparisons], file, indent=1)
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("depth_backends", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
