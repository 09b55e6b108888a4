"""One motion of a robot from a random pose, judged by the truth."""

import copy
import dataclasses as dc
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Context

from apps.studies.strokes.localized_station import (
    BASE_ERROR,
    TRUE_POSE,
    LocalizedStation,
)
from remosplat_drake.app.diagram import Application
from remosplat_drake.app.identification.excitation import commands, find_stroke
from remosplat_drake.app.identification.room import NoRoomError, Room
from remosplat_drake.app.run_readings import supervision_of
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.simulation import simulator_config
from remosplat_drake.app.velocity_run import build_velocity_run, latest_axes
from remosplat_drake.app.world import World, load_world
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.hardware.doctor.drills import base_step
from remosplat_drake.robot.actuators import Actuator, default_actuators
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.task.velocity_profile import VelocityProfile

CLEARANCE = {
    "TableGroundTruth": 0.1,
    "PandaReach": 0.1,
    "Ur5eReach": 0.05,
    "FetchReach": 0.1,
    "RidgebackReach": 0.1,
    "TwoPandasReach": 0.1,
}
"""The distance from the scene that `identify` requires [m], keyed by the
scenarios of all shipped robots. It is the default of `identify`, except for the
UR5e, whose shoulder is 61 mm from the scene in every pose."""

STROKE, BASE_STEP = "stroke", "base step"
MOTIONS = (STROKE, BASE_STEP)
"""A stroke of `remosplat identify`, and the base step of the doctor."""

_REACH = 1.0
"""Base poses lie within this distance of the scenario's start [m]."""

_TRIES = 1000
"""For each pose, at most this many random configurations are tried."""

_PAUSE = 20
"""Number of ticks to which each pause is shortened."""

_LOOK = 0.05
"""Time between two comparisons with the truth [s]."""

_NEAR = 0.05
"""Distances between links are measured up to this one [m]."""


@dc.dataclass(frozen=True)
class Start:
    """A motion from a random pose.

    Attributes:
        scenario: Name of the robot's scenario.
        motion: One of `MOTIONS`.
        is_localized: Whether the base's pose comes from a localisation.
        seed: Seed of the study.
        number: Number of the pose, which all motions of a robot share.
    """

    scenario: str
    motion: str
    is_localized: bool
    seed: int
    number: int

    @property
    def group(self) -> str:
        """Name of the robot's scenario, and the kind of motion."""
        kind = "localised" if self.is_localized else "not localised"
        return f"{self.scenario}, {self.motion}, {kind}"

    @property
    def key(self) -> str:
        """Name of the start in files."""
        return f"{self.group}, {self.seed}, {self.number}"


@dc.dataclass(frozen=True)
class Result:
    """The result of a motion.

    Attributes:
        key: Name of the start.
        no_room: Reason why no motion was possible; empty if a motion was
            possible.
        was_slowed: Whether verification slowed the motion down.
        stopped: Reason of a stop by the supervisor; empty without a stop.
        own: Smallest distance between two of the robot's parts [m]; None
            without a motion.
        scene: Smallest true clearance [m]; None without a motion.
        wrong_places: Number of comparisons in which the base was farther from
            its measured pose than the bound that was assumed.
        error_share: Largest error of the base's measured pose, at the time of
            its measurement, as a share of its bound; 0 without localisation.
        error: Reason why there is no result; empty if there is one.
    """

    key: str
    no_room: str = ""
    was_slowed: bool = False
    stopped: str = ""
    own: float | None = None
    scene: float | None = None
    wrong_places: int = 0
    error_share: float = 0.0
    error: str = ""

    @property
    def group(self) -> str:
        """Name of the robot's scenario, and the kind of motion."""
        return self.key.rsplit(", ", 2)[0]

    @property
    def touched(self) -> bool:
        """Whether the robot touched itself or the true scene."""
        distances = (self.own, self.scene)
        return any(d is not None and not d > 0.0 for d in distances)


def failed(start: Start, error: str) -> Result:
    """Makes the result of a motion that failed."""
    return Result(start.key, error=error)


def restored(fields: dict[str, Any]) -> Result:
    """Restores a result from a file's line."""
    return Result(**fields)


def starts(poses: int, seed: int) -> Iterator[Start]:
    """Yields all motions from a number of poses of each robot.

    Args:
        poses: Number of poses of each robot.
        seed: Seed of the poses.
    """
    for number in range(poses):
        for name in CLEARANCE:
            is_mobile = _place(name).world.robot.n_base > 0
            for motion in MOTIONS if is_mobile else (STROKE,):
                for localized in (False, True) if is_mobile else (False,):
                    yield Start(name, motion, localized, seed, number)


@dc.dataclass(frozen=True, eq=False)
class _Place:
    """A robot in its scene, and the distances that it keeps there."""

    scenario: Scenario
    world: World
    room: Room


@cache
def _place(name: str) -> _Place:
    scenario = load_scenario(name)
    limits = scenario.controller.velocity_limits
    limits.acceleration = limits.strict = True
    world = load_world(scenario)
    stopping = scenario.controller.self_collision.stopping
    own = SelfClearance.make(world.robot, stopping)
    period = scenario.control_period
    room = Room(world.field, own, CLEARANCE[name], period)
    return _Place(scenario, world, room)


def run_trial(start: Start) -> Result:
    """Moves a robot from a random pose, and compares it with the truth.

    Every second pose has the largest delay that is permitted before
    identification.

    Args:
        start: The start.
    """
    place = _place(start.scenario)
    robot, room = place.world.robot, place.room
    random = np.random.default_rng([start.seed, start.number])
    q0 = q = _clear_pose(room, place.world.q0, random)
    axis = int(random.integers(robot.n_u))
    scenario, result = copy.copy(place.scenario), Result(start.key)
    if start.is_localized:
        station = LocalizedStation(int(random.integers(2**32)))
        base = station.base(q0[:3])
        reading = base.reading(q0[3:], robot)
        q, room, scenario.station = reading.q_W, room.about(reading), station
        bound = reading.measurement.base_track.uncertainty
        result = _compared(result, base.error, bound)
    if start.motion == STROKE:
        try:
            stroke = find_stroke(room, q, axis, robot.velocity_limit)
        except NoRoomError as error:
            return dc.replace(result, no_room=str(error))
        line = commands(stroke, robot, robot.velocity_limit, room.dt)
        line = _hasty(line, axis)
    else:
        line = base_step(robot, room.dt)
    robot.description.actuators = _axes(start, robot)
    world = dc.replace(place.world, q0=q0)
    return _driven(scenario, world, room.own, line, result)


def _axes(start: Start, robot: RobotModel) -> list[Actuator]:
    """The models of a robot's axes, which the simulated robot obeys exactly.

    A run computes the motion since the latest measurement of the base from
    these models, so a base whose pose is localised needs them.
    """
    if start.number % 2:
        return latest_axes(robot)
    if start.is_localized:
        return default_actuators(robot.n_base, robot.n_u - robot.n_base)
    return []


def _clear_pose(
    room: Room, q0: np.ndarray, random: np.random.Generator
) -> np.ndarray:
    """A random configuration that keeps the distances of `identify`."""
    robot = room.own.robot
    first = robot.n_q - len(robot.home)
    for _ in range(_TRIES):
        q = q0.copy()
        q[first:] = random.uniform(
            robot.position_lower[first:], robot.position_upper[first:]
        )
        if first:
            q[:2] += random.uniform(-_REACH, _REACH, 2)
            q[2] = random.uniform(-np.pi, np.pi)
        if not room.problem(q):
            return q
    return q0


def _hasty(line: np.ndarray, axis: int) -> np.ndarray:
    """The same motions with short pauses between them."""
    moves = np.convolve(line[:, axis] != 0, np.ones(2 * _PAUSE + 1), "same")
    return line[moves > 0.5]


def _driven(
    scenario: Scenario,
    world: World,
    own: SelfClearance,
    line: np.ndarray,
    result: Result,
) -> Result:
    """Plays velocities in the diagram of every run, and judges the motion."""
    application = build_velocity_run(scenario, world, hardware=False)
    simulator = Simulator(application.diagram)
    ApplySimulatorConfig(simulator_config(scenario), simulator)
    root = simulator.get_mutable_context()
    simulator.AdvanceTo(2 * scenario.control_period)
    profile = application.targets
    assert isinstance(profile, VelocityProfile)
    profile.play(profile.GetMyMutableContextFromRoot(root), line)
    end = (len(line) + _PAUSE) * scenario.control_period
    while root.get_time() < end:
        simulator.AdvanceTo(min(root.get_time() + _LOOK, end))
        result = _judged(result, application, root, own)
    recorder = application.recorder
    found = recorder.trajectory(recorder.GetMyContextFromRoot(root))
    return dc.replace(result, was_slowed=bool((found.scale < 1.0).any()))


def _judged(
    result: Result, application: Application, root: Context, own: SelfClearance
) -> Result:
    """Adds a comparison of the present configuration with the truth."""
    world, told = application.world, _value(application.odometry, root)
    assert world.truth_field is not None
    true, station = told.copy(), application.station
    if station.HasOutputPort(TRUE_POSE):
        true[:3] = _value(station.GetOutputPort(TRUE_POSE), root)
        error = _value(station.GetOutputPort(BASE_ERROR), root)
        bound = _value(application.status, root).base_uncertainty
        result = _compared(result, error, np.array(bound))
    apart = float(own.distances(true, _NEAR).min())
    spheres = world.robot.spheres_at(true)
    clear = world.truth_field.clearances(spheres).minimum()
    state = supervision_of(application, root)
    stopped = state.reason if state is not None and state.is_latched else ""
    return dc.replace(
        result,
        own=apart if result.own is None else min(result.own, apart),
        scene=clear if result.scene is None else min(result.scene, clear),
        stopped=result.stopped or stopped,
    )


def _value(port, root: Context):
    """The value of a subsystem's output port."""
    return port.Eval(port.get_system().GetMyContextFromRoot(root))


def _compared(result: Result, error: np.ndarray, bound: np.ndarray) -> Result:
    """Compares an error of the base's pose with its bound, shape (2,) each."""
    share = float((error / bound).max())
    # A pose that is not known is a wrong place, too.
    is_wrong = not share <= 1.0
    return dc.replace(
        result,
        wrong_places=result.wrong_places + is_wrong,
        error_share=max(result.error_share, share),
    )
