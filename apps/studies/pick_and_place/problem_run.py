"""Runs one problem in simulation, and judges it by the true motion."""

import dataclasses as dc

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Context, EventStatus

from apps.studies.pick_and_place.problem_scenario import (
    TIME_LIMIT,
    keep_reachable,
    make_world,
    strong_enough,
)
from remosplat_drake.app.diagram import Application, build
from remosplat_drake.app.simulation import simulator_config
from remosplat_drake.generation.pick_and_place import TARGET, PickAndPlace
from remosplat_drake.grasping.gripper import ParallelGripper
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.contact_monitor import ContactReport
from remosplat_drake.task.task import TaskState
from remosplat_drake.task.task_system import TaskSystem

OFF = 0.03
"""Largest distance from the goal of an object at the right place [m]."""

UPRIGHT = np.cos(np.radians(15.0))
"""Least cosine of the tilt of a standing object."""

COMPLETE = "complete"
NO_GRASP = "no grasp fits the hand"
TOO_HEAVY = "the hand is too weak for all grasps"
NO_REACH = "no grasp is in reach at both places"
UNSOLVABLE = (NO_GRASP, TOO_HEAVY, NO_REACH)
"""Causes of problems that have no solution."""


@dc.dataclass(frozen=True)
class Outcome:
    """The outcome of a problem.

    Attributes:
        key: Family and seed of the problem.
        solid: Kind of the target's shape.
        mass: Its mass [kg].
        cause: `COMPLETE`, or the cause of the failure in a few words.
        detail: The task's own words about its failures.
        time: Simulated duration [s].
        off: Final distance of the target from its goal [m].
        error: Text of the error that ended the run; empty for none.
        draws: Number of problems that were drawn until one had a solution.
    """

    key: str
    solid: str
    mass: float
    cause: str
    detail: str = ""
    time: float = 0.0
    off: float = 0.0
    error: str = ""
    draws: int = 1


def run_problem(problem: PickAndPlace, gripper: ParallelGripper) -> Outcome:
    """Runs a problem in the dynamic station.

    Args:
        problem: The problem.
        gripper: The gripper of its robot.

    Raises:
        RemoSplatError: The scenario cannot be built.
    """
    target = problem.objects[0]
    kind, mass = target.solid.name, float(target.mass or 0.0)
    if not problem.grasps:
        return Outcome(problem.name, kind, mass, NO_GRASP)
    grasps = strong_enough(problem, gripper)
    if not grasps:
        return Outcome(problem.name, kind, mass, TOO_HEAVY)
    scenario, world = make_world(problem, gripper.robot, grasps)
    if not keep_reachable(scenario, world, gripper):
        return Outcome(problem.name, kind, mass, NO_REACH)
    application = build(scenario, world)
    judge = Judge(problem, application)
    simulator = Simulator(application.diagram)
    ApplySimulatorConfig(simulator_config(application.scenario), simulator)
    simulator.set_monitor(judge.look)
    simulator.AdvanceTo(TIME_LIMIT)
    time = simulator.get_context().get_time()
    state = judge.state
    detail = "; ".join(state.failures) if state else ""
    cause, off = judge.cause()
    return Outcome(problem.name, kind, mass, cause, detail, time, off)


class Judge:
    """Evaluates true contacts and the target's pose at every step.

    Attributes:
        state: The latest state of the task; None before the first.
        objects: The objects at their true poses.
        touched: Pairs of names with a forbidden contact.
    """

    def __init__(self, problem: PickAndPlace, application: Application):
        """Takes the ports of an application."""
        self._problem, self._application = problem, application
        assert isinstance(application.targets, TaskSystem)
        self._task = application.targets
        self._supports = {problem.pick.support, problem.place.support}
        self.state: TaskState | None = None
        self.objects = problem.objects
        self.touched: set[tuple[str, str]] = set()

    def look(self, root: Context) -> EventStatus:
        """Monitors the simulator, and ends the run when the task ends."""
        station = self._application.station
        context = station.GetMyContextFromRoot(root)
        report = station.GetOutputPort(ports.CHEAT_CONTACT).Eval(context)
        self.touched |= forbidden(report, self._supports)
        self.objects = station.GetOutputPort(ports.CHEAT_OBJECTS).Eval(context)
        self.state = self._task.state(self._task.GetMyContextFromRoot(root))
        if self.state.outcome != "running":
            diagram = self._application.diagram
            return EventStatus.ReachedTermination(diagram, "")
        return EventStatus.DidNothing()

    def cause(self) -> tuple[str, float]:
        """Returns the cause of the failure, and the target's error [m]."""
        target = self.objects[0]
        goal = self._problem.X_WO_goal
        off = np.linalg.norm(target.X_WO.translation() - goal.translation())
        tilt = target.X_WO.rotation().matrix()[2, 2]
        off = float(off)
        if self.state is None or self.state.outcome == "running":
            return "time is up", off
        if self.touched:
            return "touched: " + _kinds(self.touched), off
        if self.state.failures and self.state.outcome != "done":
            return _last_words(self.state.failures[-1]), off
        if off > OFF:
            return "put down elsewhere", off
        return (COMPLETE if tilt > UPRIGHT else "fell over"), off


def forbidden(
    report: ContactReport, supports: set[str]
) -> set[tuple[str, str]]:
    """Returns the contacts that no step of a task permits.

    Links may touch the target, and the target its supports. Other objects may
    touch everything except the target and the robot.

    Args:
        report: The contacts.
        supports: Names of the target's supports, before and after.
    """
    wanted = supports | {TARGET}
    bad = set(report.robot)
    bad |= {pair for pair in report.scene if pair[1] != "floor"}
    bad |= {pair for pair in report.objects if pair[1] != TARGET}
    return bad | {
        pair
        for pair in report.others
        if TARGET in pair and not set(pair) <= wanted
    }


def _kinds(touched: set[tuple[str, str]]) -> str:
    """The first pair, without numbers."""
    one, other = sorted(touched)[0]
    return f"{one.rstrip(' 0123456789')} and {other.rstrip(' 0123456789')}"


def _last_words(failure: str) -> str:
    return failure.rpartition(": ")[2]
