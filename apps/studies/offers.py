"""Measures whether causes are told at once, and whether offered targets work.

Targets are drawn from seeds, of kinds in turn: in the middle of a solid, under
the floor's stopping distance, and above the robot's reach. The robot is driven
to each one in simulation, and the cause that its state names is compared with
the kind. Then the cockpit's offers for it are searched, and the robot is driven
to the first one.
"""

import argparse
import dataclasses as dc
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from pydrake.math import RollPitchYaw

from apps.studies.command_line import check_least, study_main
from apps.studies.kept_trials import run_missing
from remosplat_drake.app.diagram import build
from remosplat_drake.app.run_result import REACHED, RunResult
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.simulation import run as simulate
from remosplat_drake.app.world import World, load_world
from remosplat_drake.base.pool import Job
from remosplat_drake.base.table import Table
from remosplat_drake.cockpit.offers import OfferSearch, Trouble, place_at_home
from remosplat_drake.cockpit.reach import find_reach
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.signals import standing as stands
from remosplat_drake.signals.target import Target
from remosplat_drake.signals.thing import FLOOR, MAP, SOLID

SCENARIO = "TableGroundTruth"
"""The scenario whose targets are replaced."""

TRIALS = "trials.jsonl"
"""Name of the result file in the output folder."""

IN_SOLID, IN_FLOOR, ABOVE = "in a solid", "in the floor", "above the reach"
KINDS = (IN_SOLID, IN_FLOOR, ABOVE)
"""Kinds of targets, in turn."""

_CAUSES = {IN_SOLID: (SOLID, MAP), IN_FLOOR: (FLOOR, SOLID, MAP)}
"""Causes that hold a robot before a target of a kind."""

_BEYOND = "out of reach"
"""Words of a sentence about a target above the reach."""

_SOON = 1.1
"""Delay that counts as at once: a second, and a look at the state [s]."""

_STILL = 0.01
"""Largest velocity of an axis that counts as none [m/s, rad/s]."""

_TIME_LIMIT = 12.0
"""Time that a robot has for a target [s]."""


@dc.dataclass(frozen=True)
class Trial:
    """A target that is drawn from a seed.

    Attributes:
        seed: The seed, which also gives the kind.
    """

    seed: int

    @property
    def key(self) -> str:
        """Name of the trial."""
        return f"{self.seed:04d}"

    @property
    def kind(self) -> str:
        """Kind of the target."""
        return KINDS[self.seed % len(KINDS)]


@dc.dataclass(frozen=True)
class Outcome:
    """The answers about a target.

    Attributes:
        key: Name of the trial.
        kind: Kind of the target.
        verdict: The cockpit's verdict on it.
        duration: Time that the verdict took [s].
        told: The robot's state when it was held, or out of reach.
        delay: Time from when the robot stood still, or from the start for a
            target out of reach, until that was told [s]; NaN if it never was.
        is_right: Whether the state named the kind's cause within a second.
        offers: Labels of the offers.
        works: Whether the robot reached the first offer.
        error: Text of a crash; empty otherwise.
    """

    key: str
    kind: str
    verdict: str = ""
    duration: float = float("nan")
    told: str = ""
    delay: float = float("nan")
    is_right: bool = False
    offers: tuple[str, ...] = ()
    works: bool = False
    error: str = ""


def draw_target(trial: Trial, world: World) -> np.ndarray:
    """Draws a target of a trial's kind, with the hand pointing down.

    Args:
        trial: The trial.
        world: The scene and the robot.

    Returns:
        The pose X_WT, shape (4, 4).
    """
    rng = np.random.default_rng(trial.seed)
    X_WT = np.eye(4)
    turn = RollPitchYaw([np.pi, 0.0, rng.uniform(-np.pi, np.pi)])
    X_WT[:3, :3] = turn.ToRotationMatrix().matrix()
    X_WT[:2, 3] = rng.uniform([0.6, -0.4], [1.2, 0.4])
    if trial.kind == ABOVE:
        X_WT[2, 3] = rng.uniform(2.2, 3.0)
    elif trial.kind == IN_FLOOR:
        X_WT[:2, 3] = rng.uniform([-0.2, 0.8], [0.4, 1.2])
        X_WT[2, 3] = rng.uniform(-0.1, 0.0)
    else:
        assert world.truth is not None
        # The floor is a solid, too, and a kind of its own.
        boxes = [b for b in world.truth.boxes if b.X_WP.translation()[2] > 0.1]
        box = boxes[int(rng.integers(len(boxes)))]
        inside = rng.uniform(-0.5, 0.5, 3) * box.half_extents
        X_WT[:3, 3] = box.X_WP.multiply(inside)
    return X_WT


def run_trial(trial: Trial) -> Outcome:
    """Drives to a target, and to what is offered instead.

    Args:
        trial: The trial.
    """
    scenario = load_scenario(SCENARIO)
    world = load_world(scenario)
    X_WT = draw_target(trial, world)
    law = ReactiveLaw.make(
        scenario.controller, world.robot, scenario.control_period
    )
    planner = MotionPlanner(
        world.robot, law.self_clearance, scenario.controller.guidance.planning
    )
    stopping = scenario.controller.collision.stopping
    reach = partial(find_reach, planner, world.field, stopping)
    begun = perf_counter()
    verdict = reach(world.q0, Target(X_WT)).verdict
    duration = perf_counter() - begun
    result = drive(scenario, world, X_WT)
    told, delay = told_cause(result, trial.kind)
    q = result.trajectory.q[-1]
    X_WE = world.robot.end_effector_pose(q)
    search = OfferSearch()
    p_WHome = place_at_home(world.robot, q)
    search.begin(Trouble(X_WT, X_WE, p_WHome), world.field)
    while search.is_busy:
        search.step(lambda X: reach(q, Target(X)))
    offers = search.offers
    works = bool(offers) and (
        drive(scenario, world, offers[0].X_WT).outcome == REACHED
    )
    return Outcome(
        trial.key,
        trial.kind,
        verdict,
        duration,
        told,
        delay,
        bool(told) and delay <= _SOON,
        tuple(offer.label for offer in offers),
        works,
    )


def drive(scenario: Scenario, world: World, X_WT: np.ndarray) -> RunResult:
    """Lets the robot go from its start to a target.

    Args:
        scenario: The scenario whose target is replaced.
        world: The content of the scenario's files.
        X_WT: The target, shape (4, 4).
    """
    rpy = np.degrees(RollPitchYaw(np.ascontiguousarray(X_WT[:3, :3])).vector())
    text = (
        f"{{time_limit: {_TIME_LIMIT}, targets: [{{translation:"
        f" {X_WT[:3, 3].tolist()}, rpy_deg: {rpy.tolist()}}}]}}"
    )
    return simulate(build(load_scenario(SCENARIO, text), world))


def told_cause(result: RunResult, kind: str) -> tuple[str, float]:
    """Returns the first state that names the kind's cause, and its delay.

    Args:
        result: How the run went.
        kind: Kind of the target.

    Returns:
        The sentence, empty if there was none, and the time from when the robot
        stood still [s]; of a target out of reach, from the start.
    """
    for time, standing in result.standings:
        if kind == ABOVE and _BEYOND in standing.text:
            return standing.text, time
        is_held = standing.kind == stands.HELD
        if kind != ABOVE and is_held and standing.cause in _CAUSES[kind]:
            return standing.text, time - _rest_begins(result, time)
    return "", float("nan")


def _rest_begins(result: RunResult, time: float) -> float:
    """When the motion ended after which the robot stood still at a time [s]."""
    trajectory = result.trajectory
    moves = np.abs(trajectory.u).max(axis=1) > _STILL
    before = trajectory.time[: len(moves)][moves]
    return float(before[before < time].max(initial=0.0))


def failed(trial: Trial, error: str) -> Outcome:
    """Makes the outcome of a trial that crashed; it is tried again.

    Args:
        trial: The trial.
        error: Text of the error.
    """
    return Outcome(trial.key, trial.kind, error=error)


def restored(fields: dict[str, Any]) -> Outcome:
    """Makes an outcome of the fields that a file holds."""
    fields["offers"] = tuple(fields["offers"])
    return Outcome(**fields)


def table_of(outcomes: Sequence[Outcome]) -> Table:
    """Makes a table of causes and offers by kind.

    Args:
        outcomes: The outcomes.
    """
    rows = []
    for kind in KINDS:
        some = [each for each in outcomes if each.kind == kind]
        if not some:
            continue
        right = [each for each in some if each.is_right]
        offered = [each for each in some if each.offers]
        delay = max((each.delay for each in right), default=np.nan)
        row = (
            kind,
            f"{len(right)} of {len(some)}",
            f"{delay:.2f}",
            f"{1e3 * np.median([each.duration for each in some]):.0f}",
            f"{sum(each.works for each in offered)} of {len(offered)}",
        )
        rows.append(row)
    header = ("kind", "right cause", "slowest [s]", "verdict [ms]", "works")
    return Table("", header, tuple(rows))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the flags."""
    parser.add_argument(
        "--count", type=int, default=100, metavar="N", help="targets (100)"
    )
    parser.add_argument(
        "--jobs", type=int, default=2, metavar="N", help="at a time (2)"
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("results/offers"),
        metavar="DIR",
        help=f"where {TRIALS} goes (results/offers)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Runs the trials that have no line yet, and prints the table."""
    check_least("offers", arguments, count=1, jobs=0)
    outcomes = run_missing(
        [Job(Trial(s), run_trial, failed) for s in range(arguments.count)],
        arguments.output / TRIALS,
        restored,
        arguments.jobs,
        "driving to targets",
    )
    print(table_of(outcomes).to_markdown(), end="")
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line."""
    return study_main("offers", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
