"""Suggests a start and a target in a scene without a task."""

import dataclasses as dc
from collections.abc import Callable, Iterable, Iterator

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot import planar_pose
from remosplat_drake.robot.reach import arm_reach, shoulder
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.task.hand_places import HandPlaces

NEAR, _FAR = 0.05, 0.12
"""Range of the hand's clearance at the target [m]."""

_HEIGHTS = np.arange(0.35, 1.2, 0.05)
"""Heights of targets above the floor [m]."""

_ON_A_TABLE = 0.25
"""For an arm on a fixed base, which stands on its work surface, the heights of
targets are lower by this amount [m]."""

_DISTANCES = (0.9, 1.1, 1.3, 1.5, 1.8, 2.2)
"""Distances from the base to the target, in the order in which they are tried
[m]."""

_NEARER = (0.7, 0.5, 0.9)
"""Distances from a fixed base to the target, as fractions of the arm's reach,
in the order in which they are tried."""

_DIRECTIONS = 24
"""Number of directions from which a base may face a target."""

_STRETCHED = 0.7
"""Suggested targets are at most this fraction of the arm's reach away. An arm
whose hand points down cannot be fully stretched."""

_ROOM = 0.15
"""Clearance that the whole robot must have at the start [m]."""

_BASE_HEIGHT, _BASE_ROOM = 0.2, 0.4
"""A base counts as free if a point above it has enough clearance: height of
this point, and the clearance that it must have [m]."""

_WAY, _WAY_ROOM = np.linspace(0, 1, 25)[:, None], 0.04
"""Parameters, from 0 to 1, of points on the hand's straight path to the target,
and the clearance that these points must have [m]."""

_COMPARED = 50
"""At most this many starts are compared."""


@dc.dataclass(frozen=True, eq=False)
class Suggestion:
    """A start and a target for a robot.

    Attributes:
        base_pose: x, y and yaw of the base in W, shape (3,) [m, m, rad]; None
            for a robot without a mobile base, which stands at W's origin.
        X_WT: Target pose of the end effector, with the gripper down.
        X_WG: Pose of the map's frame G, which was W during the search. It is
            the identity, unless the map must be moved so that a robot without a
            mobile base stands in a free place.
    """

    base_pose: np.ndarray | None
    X_WT: RigidTransform
    X_WG: RigidTransform = dc.field(default_factory=RigidTransform)


def suggest_task(
    robot: RobotModel,
    field: DistanceField,
    lower: np.ndarray,
    upper: np.ndarray,
    is_free: Callable[[np.ndarray], np.ndarray],
    may_move_map: bool = False,
) -> Suggestion:
    """Finds a free place for the base and a target in front of it.

    The function prefers targets near the base. The straight path from above the
    base to the target is free, so that no wall is between them; the whole robot
    may still be unable to follow this path. The search for targets begins in
    the middle of the space and proceeds outwards. At each point of the floor,
    it proceeds from the lowest height to the greatest. Of several starts, the
    function returns the start at which the largest part of the robot is in
    space that is known to be free, since space behind a wall is unknown.

    Args:
        robot: The robot; without a mobile base, it stands at the origin.
        field: Distance field of the scene, 1-Lipschitz, with the floor at
            z = 0.
        lower: Lower corner of the seen space, in W, shape (3,) [m].
        upper: Upper corner of the seen space, in W, shape (3,) [m].
        is_free: Function that returns which of n points in W, shape (n, 3) [m],
            are known to be free, shape (n,). It is needed, since a splat does
            not distinguish a solid's inside from its outside.
        may_move_map: Whether the map may be moved if a robot without a mobile
            base does not fit at the origin, or does not reach a target from
            there.

    Raises:
        RemoSplatError: There is no such place.
    """
    places = _hand_places(robot, field, lower, upper)
    targets = _Kept(_free_ones(places.outwards(), is_free))
    if next(iter(targets), None) is None:
        raise RemoSplatError("found no place for the hand close to the scene")
    distances, farthest = _DISTANCES, np.inf
    if not robot.n_base:
        try:
            return _from_the_origin(robot, field, places, is_free)
        except RemoSplatError:
            if not may_move_map:
                raise
        farthest = _STRETCHED * arm_reach(robot)
        distances = tuple(share * farthest for share in _NEARER)
    height = shoulder(robot, robot.q_home)[2]
    for distance in distances:
        near = (
            some[np.hypot(distance, some[:, 2] - height) <= farthest]
            for some in targets
        )
        found = _best_start(robot, field, near, distance, is_free)
        if found is not None:
            start, p_WT = found
            task = Suggestion(start, _pointing_down(p_WT))
            return task if robot.n_base else _at_the_origin(task)
    raise RemoSplatError("found no free place for the robot near the scene")


class _Kept:
    """Arrays of an iterator, each of which is computed once, on first use."""

    def __init__(self, source: Iterator[np.ndarray]):
        self._source = source
        self._made: list[np.ndarray] = []

    def __iter__(self) -> Iterator[np.ndarray]:
        yield from self._made
        for each in self._source:
            self._made.append(each)
            yield each


def _free_ones(
    places: Iterable[np.ndarray], is_free: Callable[[np.ndarray], np.ndarray]
) -> Iterator[np.ndarray]:
    """Yields the places that are known to be free, in non-empty arrays."""
    for some in places:
        free = some[is_free(some)] if len(some) else some
        if len(free):
            yield free


def _from_the_origin(
    robot: RobotModel,
    field: DistanceField,
    places: HandPlaces,
    is_free: Callable[[np.ndarray], np.ndarray],
) -> Suggestion:
    """Returns a target that an arm on a fixed base can reach."""
    start = robot.spheres_at(robot.home)
    if field.clearances(start, _ROOM).minimum() < 0:
        raise RemoSplatError(
            f"{robot.description.name} would stand inside the scene at the"
            " origin; set scene.X_WG to move the map"
        )
    p_WA, reach = shoulder(robot, robot.home), _STRETCHED * arm_reach(robot)
    for targets in _free_ones(places.outwards(p_WA, reach), is_free):
        near = targets[np.linalg.norm(targets - p_WA, axis=1) < reach]
        if len(near):
            return Suggestion(None, _pointing_down(near[0]))
    raise RemoSplatError(
        f"{robot.description.name} reaches no target from the origin; set "
        "scene.X_WG to move the map"
    )


def _at_the_origin(task: Suggestion) -> Suggestion:
    """Moves the map so that the robot's base is at W's origin."""
    assert task.base_pose is not None
    x, y, yaw = task.base_pose
    X_WG = RigidTransform(RollPitchYaw(0, 0, yaw), [x, y, 0]).inverse()
    return Suggestion(
        None, _pointing_down(X_WG @ task.X_WT.translation()), X_WG
    )


def _pointing_down(p_WT: np.ndarray) -> RigidTransform:
    """A target's pose with the gripper down."""
    return RigidTransform(RollPitchYaw(np.pi, 0, 0), p_WT.tolist())


def _best_start(
    robot: RobotModel,
    field: DistanceField,
    targets: Iterable[np.ndarray],
    distance: float,
    is_free: Callable[[np.ndarray], np.ndarray],
) -> tuple[np.ndarray, np.ndarray] | None:
    """Returns the best start at a distance from a target, and the target."""
    found, known = [], []
    for start, target in _roomy_starts(robot, field, targets, distance):
        over = np.append(start[:2], target[2])
        way = Spheres.at(over + _WAY * (target - over))
        if field.clearances(way, 2 * _WAY_ROOM).minimum() < _WAY_ROOM:
            continue
        spheres = _standing(robot, start)
        if field.clearances(spheres, _ROOM).minimum() >= _ROOM:
            found.append((start, target))
            known.append(is_free(spheres.p_WS).mean())
        if len(found) == _COMPARED:
            break
    return found[int(np.argmax(known))] if found else None


def _roomy_starts(
    robot: RobotModel,
    field: DistanceField,
    targets: Iterable[np.ndarray],
    distance: float,
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yields starts with space for a base, and their targets."""
    floor = float(robot.spheres_at(robot.q_home).ignore_below.max())
    for some in targets:
        starts, p_WT = _starts(some, distance)
        p_WB = np.insert(starts[:, :2], 2, _BASE_HEIGHT, axis=1)
        room = field.clearances(
            Spheres.at(p_WB, ignore_below=floor), _BASE_ROOM
        ).per_sphere(len(p_WB))
        fits = room >= _BASE_ROOM
        yield from zip(starts[fits], p_WT[fits], strict=True)


def _standing(robot: RobotModel, start: np.ndarray) -> Spheres:
    """Returns the spheres of a robot at home, with its base at x, y and yaw."""
    if robot.n_base:
        return robot.spheres_at(np.concatenate([start, robot.home]))
    X_WB = planar_pose.matrix(start)
    spheres = robot.spheres_at(robot.home)
    return dc.replace(
        spheres,
        p_WS=spheres.p_WS @ X_WB[:3, :3].T + X_WB[:3, 3],
        R_WL=X_WB[:3, :3] @ spheres.R_WL,
    )


def _hand_places(
    robot: RobotModel,
    field: DistanceField,
    lower: np.ndarray,
    upper: np.ndarray,
) -> HandPlaces:
    """Returns places where a hand that points down might be near a surface."""
    heights = _HEIGHTS if robot.n_base else _HEIGHTS - _ON_A_TABLE
    heights = heights[(lower[2] < heights) & (upper[2] > heights)]
    p_WA = shoulder(robot, robot.q_home)
    heights = heights[np.abs(heights - p_WA[2]) < _STRETCHED * arm_reach(robot)]
    return HandPlaces(
        field,
        _hand_pointing_down(robot),
        np.asarray(lower[:2], float),
        np.asarray(upper[:2], float),
        heights,
        NEAR,
        _FAR,
    )


def _hand_pointing_down(robot: RobotModel) -> Spheres:
    """Returns the spheres of a hand that points down, with E at the origin."""
    q = robot.q_home
    spheres = robot.spheres_at(q).select(robot.leading_spheres)
    X_WE = robot.end_effector_pose(q)
    R = RollPitchYaw(np.pi, 0, 0).ToRotationMatrix().matrix() @ X_WE[:3, :3].T
    return dc.replace(
        spheres,
        p_WS=(spheres.p_WS - X_WE[:3, 3]) @ R.T,
        R_WL=R @ spheres.R_WL,
    )


def _starts(
    targets: np.ndarray, distance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Base poses that face targets, and these targets: (k, 3) and (k, 3)."""
    angle = np.linspace(-np.pi, np.pi, _DIRECTIONS, endpoint=False)
    offset = distance * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    p_WT = np.repeat(targets, _DIRECTIONS, axis=0)
    p_WB = p_WT[:, :2] - np.tile(offset, (len(targets), 1))
    return np.column_stack([p_WB, np.tile(angle, len(targets))]), p_WT
