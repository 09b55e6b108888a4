"""How true the convex shapes of imported robots are to their makers' meshes.

    python -m apps.studies.true_shapes fetch=robots/fetch/fetch.urdf

Robots are placed at home, in the states that their files name, and at random.
FCL measures how far the meshes of two links are apart; where that is less than
50 mm, it is compared with the distance of their convex shapes. Links that cut
each other, or one of which is in the other, are left out, and so are those that
have spheres, boxes or cylinders besides meshes.
"""

import argparse
import dataclasses as dc
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from apps.studies.command_line import study_main
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.table import Table
from remosplat_drake.commands.tables import open_console, print_table
from remosplat_drake.robot.fitting.mesh_truth import NEAR, is_inside
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.link_shapes import convert_shapes
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.sources import read_robot
from remosplat_drake.robot.importing.srdf import find_srdf, read_srdf
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.robot.self_collision.kernels.all_distances import (
    pair_distances,
)
from remosplat_drake.robot.self_collision.link_pairs import (
    ALWAYS,
    find_link_pairs,
)
from remosplat_drake.robot.self_collision.shape_pairs import ShapePairs
from remosplat_drake.robot.self_collision.shapes import read_collision_shapes

POSTURES = 300
"""Number of random postures."""

STOWED = {
    "fetch": {
        "stow": (0.1, 1.32, 1.4, -0.2, 1.72, 0, 1.66, 0),
        "ready": (0.386, 1.32, 0.7, 0, -2, 0, -0.57, 0),
    }
}
"""Positions of the arm in states that makers name elsewhere [m, rad]."""


@dc.dataclass(frozen=True)
class Errors:
    """How much nearer links are by their shapes than by their meshes.

    Attributes:
        robot: The robot's name.
        named: Number of postures that its makers name, home among them.
        shapes: Number of its convex shapes.
        error: All errors, shape (k,) [m].
        named_error: Those in postures that are named, shape (j,) [m].
        worst: What the largest error is of.
    """

    robot: str
    named: int
    shapes: int
    error: np.ndarray
    named_error: np.ndarray
    worst: str

    @property
    def row(self) -> tuple[str, ...]:
        """The cells of a table."""
        named = self.named_error.max(initial=0.0)
        return (
            self.robot,
            str(self.shapes),
            str(self.named),
            f"{1e3 * named:.1f}",
            str(len(self.error)),
            f"{1e3 * self.error.min(initial=0.0):.1f}",
            f"{1e3 * np.quantile(self.error, 0.99):.1f}",
            f"{1e3 * self.error.max():.1f}",
            self.worst,
        )


class Meshes:
    """The makers' meshes of a robot's links, as FCL takes them."""

    def __init__(self, source: Path):
        """Reads the collision meshes that a robot's file names.

        Args:
            source: The robot's file.

        Raises:
            RemoSplatError: It, or a mesh, cannot be read, or FCL is missing.
        """
        try:
            import fcl
        except ModuleNotFoundError as error:
            problem = "true_shapes needs python-fcl: pip install python-fcl"
            raise RemoSplatError(problem) from error
        packages = Packages(source, {})
        urdf, _ = read_robot(source, packages, {}, Findings())
        for link in urdf.links.values():
            if link.find("collision/geometry/mesh") is not None:
                for visual in link.findall("visual"):
                    link.remove(visual)
        with tempfile.TemporaryDirectory() as folder:
            meshes = convert_shapes(urdf, packages, Path(folder), Findings())
        # What else a link is made of is no approximation, but hides its mesh.
        self.triangles = {
            link: np.concatenate(own)
            for link, own in meshes.items()
            if all(
                shape.tag == "mesh"
                for shape in urdf.links[link].iterfind("collision/geometry/*")
            )
        }
        path = find_srdf(source)
        self.states = {} if path is None else read_srdf(path, urdf).states
        self._fcl = fcl
        self._models = {}
        for link, own in self.triangles.items():
            model = fcl.BVHModel()
            model.beginModel(len(own), 3 * len(own))
            corners = np.arange(3 * len(own)).reshape(-1, 3)
            model.addSubModel(own.reshape(-1, 3), corners)
            model.endModel()
            self._models[link] = model

    def distance(
        self, links: tuple[str, str], X_WA: np.ndarray, X_WB: np.ndarray
    ) -> float:
        """Measures how far two links are apart [m].

        Args:
            links: Names of the links.
            X_WA: Pose of the first, shape (4, 4).
            X_WB: Pose of the second, shape (4, 4).

        Returns:
            The distance; zero where they cut each other, or one is in the
            other.
        """
        fcl = self._fcl
        a, b = (
            fcl.CollisionObject(
                self._models[link], fcl.Transform(X[:3, :3], X[:3, 3])
            )
            for link, X in zip(links, (X_WA, X_WB), strict=True)
        )
        request = fcl.DistanceRequest(enable_nearest_points=True)
        result = fcl.DistanceResult()
        distance = fcl.distance(a, b, request, result)
        if not 0.0 < distance < NEAR:
            return max(distance, 0.0)
        p_WA, p_WB = result.nearest_points
        p_A = (p_WB - X_WA[:3, 3]) @ X_WA[:3, :3]
        p_B = (p_WA - X_WB[:3, 3]) @ X_WB[:3, :3]
        inside = is_inside(p_A, self.triangles[links[0]])
        inside |= is_inside(p_B, self.triangles[links[1]])
        return 0.0 if inside else distance


def measure(robot: RobotModel, meshes: Meshes, postures: int) -> Errors:
    """Compares a robot's shapes with its meshes.

    Args:
        robot: The robot.
        meshes: The meshes that its shapes were made from.
        postures: Number of random postures.
    """
    shapes = read_collision_shapes(robot.description, robot.spheres)
    found = find_link_pairs(robot, shapes)
    always = [p for p, why in found.left_out.items() if why == ALWAYS]
    links = [
        pair
        for pair in (*found.watched, *always)
        if set(pair) <= meshes.triangles.keys()
    ]
    pairs = ShapePairs.make(robot, shapes, links)
    arrays = pairs.arrays(np.zeros(len(pairs)))
    named = _named_states(robot, meshes)
    errors, named_errors, worst = [], [], (0.0, "none")
    for i, q in enumerate([*named, *_random_states(robot, postures)]):
        X_WL = robot.body_poses(q)
        distances = pair_distances(arrays, X_WL, np.inf)
        for pair, distance in zip(
            links, np.minimum.reduceat(distances, pairs.start[:-1]), strict=True
        ):
            if distance > NEAR:
                continue
            X_WA, X_WB = (X_WL[robot.tree.index(link)] for link in pair)
            true = meshes.distance(pair, X_WA, X_WB)
            if not 0.0 < true < NEAR:
                continue
            error = true - distance
            errors.append(error)
            if i < len(named):
                named_errors.append(error)
            text = f"{' and '.join(pair)}, {1e3 * true:.0f} mm apart"
            worst = max(worst, (error, text))
    return Errors(
        robot.description.name,
        len(named),
        len(shapes),
        np.array(errors or [0.0]),
        np.array(named_errors),
        worst[1],
    )


def _named_states(robot: RobotModel, meshes: Meshes) -> list[np.ndarray]:
    states = [robot.q_home]
    for positions in meshes.states.values():
        if set(robot.description.arm.joints) <= positions.keys():
            states.append(robot.q_home)
            states[-1][-len(robot.home) :] = [
                positions[joint] for joint in robot.description.arm.joints
            ]
    for arm in STOWED.get(robot.description.name, {}).values():
        states.append(robot.q_home)
        states[-1][-len(robot.home) :] = arm
    return states


def _random_states(robot: RobotModel, count: int) -> np.ndarray:
    free = np.isfinite(robot.position_lower)
    lower = np.where(free, robot.position_lower, 0.0)
    upper = np.where(free, robot.position_upper, 0.0)
    # Not the postures that importing looks at.
    return np.random.default_rng(1).uniform(lower, upper, (count, robot.n_q))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "robots",
        nargs="+",
        metavar="ROBOT=FILE",
        help="a shipped or imported robot, and its makers' file",
    )
    parser.add_argument(
        "--postures",
        type=int,
        default=POSTURES,
        help=f"how many random postures ({POSTURES})",
    )
    parser.add_argument("--output", type=Path, help="Markdown file to write")


def run(args: argparse.Namespace) -> int:
    """Measures all robots, and prints a table."""
    if not 0 <= args.postures <= 1_000_000:
        problem = f"expected 0 to 1000000, got {args.postures}"
        raise FieldError("true_shapes", "--postures", problem)
    rows = []
    for text in args.robots:
        name, equals, source = text.partition("=")
        if not (name and equals and source):
            raise FieldError("true_shapes", text, "expected ROBOT=FILE")
        meshes = Meshes(Path(source).expanduser())
        rows.append(measure(load_robot(name), meshes, args.postures).row)
    table = Table(
        "",
        (
            "robot",
            "shapes",
            "named postures",
            "worst there [mm]",
            "near pairs in all",
            "least [mm]",
            "99 % [mm]",
            "worst [mm]",
            "which is of",
        ),
        tuple(rows),
    )
    print_table(open_console(), table)
    if args.output:
        write_atomically(args.output, table.to_markdown())
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line; returns the exit code."""
    return study_main("true_shapes", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
