"""`Trial`: a seed, its situation, the stated cause, and actions that help."""

import dataclasses as dc
import tempfile
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from apps.studies.causes.drive import Drive, drive, first_cause, held_since
from apps.studies.causes.faults import LASTS
from apps.studies.causes.judge import is_true
from apps.studies.causes.situations import (
    KINDS,
    MOVER,
    Situation,
    draw_situation,
    with_target,
)
from remosplat_drake.app.stages.teleoperation import wrist_camera_mount
from remosplat_drake.cockpit.offers import Offer, OfferSearch, trouble_of
from remosplat_drake.cockpit.reach import is_within_reach
from remosplat_drake.signals.motion_status import MotionStatus
from remosplat_drake.signals.target import Target

RELEASE, WAIT = "release", "wait"
"""Actions other than offered targets."""

_SOON = 1.1
"""A cause must be stated within this time [s]: one second, plus the time
between two checks."""

_LONGER = 0.3
"""Time for which a run continues after a cause was stated [s]."""


@dc.dataclass(frozen=True)
class Trial:
    """A situation that is drawn from a seed.

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
        """Kind of the situation."""
        return KINDS[self.seed % len(KINDS)]


@dc.dataclass(frozen=True)
class Outcome:
    """The result of a trial.

    Attributes:
        key: Name of the trial.
        kind: Kind of the situation.
        cause: The first cause that was stated; empty for none.
        told: The state with this cause.
        delay: Time from when the cause could be stated to its statement [s];
            NaN without one.
        is_true: Whether the stated cause is the true one.
        is_free: Whether the robot reached the target, since nothing held it.
        actions: Labels of the offered actions.
        works: Whether the first one worked.
        error: Text of a crash; empty otherwise.
    """

    key: str
    kind: str
    cause: str = ""
    told: str = ""
    delay: float = float("nan")
    is_true: bool = False
    is_free: bool = False
    actions: tuple[str, ...] = ()
    works: bool = False
    error: str = ""

    @property
    def is_right(self) -> bool:
        """Whether the cause was stated within a second."""
        return self.is_true and self.delay <= _SOON


def run_trial(trial: Trial) -> Outcome:
    """Runs a situation until a cause is stated, and executes the offer.

    Args:
        trial: The trial.
    """
    with tempfile.TemporaryDirectory() as folder:
        situation = draw_situation(trial.seed, Path(folder))
        run = _drive(situation)
        told = run.first
        if told is None:
            return Outcome(trial.key, trial.kind, is_free=bool(run.reached))
        time, status = told
        robot, ticks = situation.world.robot, run.trajectory
        at = min(int(np.searchsorted(ticks.time, time)), len(ticks.q) - 1)
        q = ticks.q[at]
        X_WEs = np.array([robot.end_effector_pose(each) for each in ticks.q])
        actions, works = _helped(situation, run, q, status)
        since = held_since(run, X_WEs, situation.X_WT[:3, 3], time, status)
        return Outcome(
            trial.key,
            trial.kind,
            status.cause,
            status.text,
            float(time - since),
            bool(is_true(status, situation, time, q)),
            False,
            actions,
            bool(works),
        )


def _drive(situation: Situation) -> Drive:
    """Runs until a cause was stated, or to the end for stops and waits."""
    goes_on = situation.kind == MOVER or np.isfinite(situation.fault_at)

    def until(time: float, motion_history) -> bool:
        told = first_cause(motion_history)
        return not goes_on and told is not None and time - told[0] > _LONGER

    return drive(
        situation.scenario,
        situation.world,
        press_at=situation.press_at,
        release_at=situation.fault_at + LASTS + 1.0,
        until=until,
    )


def _helped(
    situation: Situation, run: Drive, q: np.ndarray, status: MotionStatus
) -> tuple[tuple[str, ...], bool]:
    """Returns the labels of offered actions, and whether the first works."""
    if situation.kind == MOVER:
        return (WAIT,), run.reached
    if np.isfinite(situation.fault_at):
        return (RELEASE,), run.reached
    if not situation.drives:
        return (), False
    offers = find_offers(situation, q, status)
    if not offers:
        return (), False
    works = try_offer(situation, q, offers[0])
    return tuple(offer.label for offer in offers), works


def find_offers(
    situation: Situation, q: np.ndarray, status: MotionStatus
) -> tuple[Offer, ...]:
    """Searches for reachable targets, like the cockpit.

    Args:
        situation: The run.
        q: Configuration in which the robot is held, shape (n_q,) [m, rad].
        status: The state.
    """
    world, scenario = situation.world, situation.scenario
    robot, planner = world.robot, situation.planner
    stopping = scenario.controller.collision.stopping
    mount, X_EC = wrist_camera_mount(scenario, robot), None
    if mount is not None:
        X_EC = np.linalg.inv(robot.end_effector_pose(q)) @ mount.pose(q)
    target = Target(situation.X_WT)
    trouble = trouble_of(status, target, robot, q, X_EC)
    ticks = count()
    search = OfferSearch(lambda: float(next(ticks)))
    search.begin(trouble, world.field)
    works = partial(is_within_reach, planner, world.field, stopping, q)
    while search.is_busy:
        search.step(lambda X_WT: works(Target(X_WT)))
    return search.offers


def try_offer(situation: Situation, q: np.ndarray, offer: Offer) -> bool:
    """Returns whether the robot reaches an offered target.

    Args:
        situation: The run.
        q: Configuration in which it is held, shape (n_q,) [m, rad].
        offer: The offer.
    """
    scenario = with_target(
        situation.scenario.source, offer.X_WT, situation.fields
    )
    world = dc.replace(situation.world, q0=q)
    return drive(scenario, world, until=lambda *_: False).reached


def failed(trial: Trial, error: str) -> Outcome:
    """Makes the outcome of a trial that crashed; it is tried again.

    Args:
        trial: The trial.
        error: Text of the error.
    """
    return Outcome(trial.key, trial.kind, error=error)


def restored(fields: dict[str, Any]) -> Outcome:
    """Makes an outcome of the fields that a file holds."""
    fields["actions"] = tuple(fields["actions"])
    return Outcome(**fields)
