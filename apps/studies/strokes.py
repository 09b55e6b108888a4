"""Runs the motions of `identify` from random poses, and counts contacts.

Robots start at random configurations that keep distances from the scene and
between links. A random axis makes the stroke that `remosplat identify` would
choose there, in simulation and with the diagram of every run. Every second
robot has the largest delay that is permitted before identification.
"""

import argparse
import dataclasses as dc
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator

from apps.studies.command_line import check_least, study_main
from remosplat_drake.app.identification.excitation import commands, find_stroke
from remosplat_drake.app.identification.room import NoRoomError, Room
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.velocity_run import build_velocity_run, latest_axes
from remosplat_drake.app.world import World, load_world
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.progress import Progress
from remosplat_drake.commands.number_flags import at_least_one, whole_number
from remosplat_drake.commands.tables import open_console
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.task.velocity_profile import VelocityProfile

SCENARIOS = (
    "TableGroundTruth",
    "PandaReach",
    "Ur5eReach",
    "FetchReach",
    "RidgebackReach",
    "TwoPandasReach",
)
"""A scenario of each shipped robot."""

_CLEARANCE = 0.1
"""Distance from the scene at the start, as `identify` requires it [m]."""

_REACH = 0.3
"""Base poses lie within this distance of the scenario's start [m]."""

_TRIES = 1000
"""Largest number of random configurations for a pose."""

_PAUSE = 20
"""Number of ticks to which each pause is shortened."""


@dc.dataclass
class Strokes:
    """Results of the strokes of a robot.

    Attributes:
        scenario: Name of its scenario.
        poses: Number of poses.
        without_room: Number of poses without a possible stroke.
        held_back: Number of strokes that verification slowed down.
        contacts: Number of strokes in which the robot touched itself or the
            true scene.
        own: Smallest distance between two of its parts [m].
        scene: Smallest true clearance [m].
    """

    scenario: str
    poses: int = 0
    without_room: int = 0
    held_back: int = 0
    contacts: int = 0
    own: float = np.inf
    scene: float = np.inf

    def add(self, found: Trajectory, world: World, own: SelfClearance) -> None:
        """Judges a stroke by the truth.

        Args:
            found: Motion of the robot.
            world: The true scene, and the robot.
            own: The distances of the robot's own parts.
        """
        assert world.truth_field is not None
        moved = found.q[:: max(len(found.q) // 150, 1)]
        apart = min(float(own.distances(q, 0.05).min()) for q in moved)
        clear = min(
            world.truth_field.clearances(world.robot.spheres_at(q)).minimum()
            for q in moved
        )
        self.held_back += bool((found.scale < 1.0).any())
        self.contacts += min(apart, clear) <= 0.0
        self.own, self.scene = min(self.own, apart), min(self.scene, clear)


def strokes_of(name: str, poses: int, seed: int = 0) -> Strokes:
    """Lets a robot make strokes from random poses.

    Args:
        name: Name of its scenario.
        poses: Number of poses.
        seed: Seed of the poses and axes.
    """
    scenario = load_scenario(name)
    limits = scenario.controller.velocity_limits
    limits.acceleration = limits.strict = True
    world, rng = load_world(scenario), np.random.default_rng(seed)
    robot = world.robot
    own = SelfClearance.make(robot, scenario.controller.self_collision.stopping)
    room = Room(world.field, own, _CLEARANCE, scenario.control_period)
    result = Strokes(name)
    for k in range(poses):
        q0 = _clear_pose(room, world.q0, rng)
        axis = int(rng.integers(robot.n_u))
        result.poses += 1
        try:
            stroke = find_stroke(room, q0, axis, robot.velocity_limit)
        except NoRoomError:
            result.without_room += 1
            continue
        line = commands(stroke, robot, robot.velocity_limit, room.dt)
        # A simulated omnidirectional base follows commands without delay.
        is_late = k % 2 and not robot.is_omnidirectional
        robot.description.actuators = latest_axes(robot) if is_late else []
        there = dc.replace(world, q0=q0)
        result.add(_driven(scenario, there, _hasty(line, axis)), there, own)
    return result


def _clear_pose(
    room: Room, q0: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    robot = room.own.robot
    first = robot.n_q - len(robot.home)
    for _ in range(_TRIES):
        q = q0.copy()
        q[first:] = rng.uniform(
            robot.position_lower[first:], robot.position_upper[first:]
        )
        if first:
            q[:2] += rng.uniform(-_REACH, _REACH, 2)
            q[2] = rng.uniform(-np.pi, np.pi)
        if not room.problem(q):
            return q
    return q0


def _hasty(line: np.ndarray, axis: int) -> np.ndarray:
    """The same motions with short pauses between them."""
    moves = np.convolve(line[:, axis] != 0, np.ones(2 * _PAUSE + 1), "same")
    return line[moves > 0.5]


def _driven(scenario: Scenario, world: World, line: np.ndarray) -> Trajectory:
    application = build_velocity_run(scenario, world, hardware=False)
    simulator = Simulator(application.diagram)
    root = simulator.get_mutable_context()
    simulator.AdvanceTo(2 * scenario.control_period)
    profile = application.targets
    assert isinstance(profile, VelocityProfile)
    profile.play(profile.GetMyMutableContextFromRoot(root), line)
    simulator.AdvanceTo((len(line) + _PAUSE) * scenario.control_period)
    recorder = application.recorder
    return recorder.trajectory(recorder.GetMyContextFromRoot(root))


def main(argv: Sequence[str] | None = None) -> int:
    """Runs all robots' strokes; returns 1 if one touched anything."""
    return study_main("strokes", __doc__, _add_arguments, _study, argv)


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--poses",
        type=at_least_one,
        default=1000,
        metavar="N",
        help="number of poses of each robot (default: %(default)s)",
    )
    parser.add_argument(
        "--seed",
        type=whole_number,
        default=0,
        metavar="N",
        help="seed of the poses; processes with different seeds share the work"
        " (default: %(default)s)",
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        help="JSON file for the results, written after each robot",
    )


def _study(arguments: argparse.Namespace) -> int:
    check_least("strokes", arguments, seed=0)
    found = []
    with Progress(open_console(stderr=True)) as progress:
        for name in progress.over(SCENARIOS, "moving axes"):
            found.append(strokes_of(name, arguments.poses, arguments.seed))
            text = json.dumps([dc.asdict(s) for s in found], indent=2) + "\n"
            if arguments.output:
                write_atomically(arguments.output, text)
    print(text, end="")
    return int(any(strokes.contacts for strokes in found))


if __name__ == "__main__":
    sys.exit(main())
