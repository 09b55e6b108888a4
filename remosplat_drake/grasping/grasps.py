"""`Grasp`: a pose of a hand around an object; plans and ranks grasps."""

import dataclasses as dc
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from remosplat_drake.grasping.antipodal import AntipodalPairs, antipodal_pairs
from remosplat_drake.grasping.gripper import ParallelGripper
from remosplat_drake.grasping.kernels.hand_clearance import hand_clearances
from remosplat_drake.grasping.surface import Surface

FRICTION = 0.2
"""Coefficient of friction for the choice of grasps. With this value, grasped
faces are parallel to within 11 degrees, so that a hand does not slide off a
bottle's shoulder.
"""

GRIPPING = 0.8
"""Coefficient of friction for the force of the hand. It is two thirds of the
coefficient between pads and objects in the dynamic station."""

LEAST_FORCE = 10.0
"""A finger presses with at least this force [N]."""

OPENING = 0.01
"""Distance by which each finger closes until it grips [m]."""

LEAST_OPENING = 0.002
"""If an object is almost as wide as the open hand, each finger closes by less
than `OPENING`, but at least by this distance, until it grips [m]."""

APPROACHES = 12
"""Number of directions from which each pair of points is approached."""

DEPTHS = (-0.005, 0.0, 0.005)
"""Grasps are planned with the gripped points at these distances from the end
effector's frame, along the direction of approach [m]."""

ENOUGH = 0.02
"""The score does not increase with the hand's clearance above this [m]."""

GIVE = 0.001
"""Length by which a pad is compressed when it presses on an object [m]."""

LEVER = 0.05
"""`lever` adds nothing to the score if the centre of mass is at least this far
from the closing axis [m]."""


@dc.dataclass(frozen=True, eq=False)
class Grasp:
    """A pose of the hand around an object, and its width.

    Attributes:
        X_OE: Pose of the end effector in the object's frame, shape (4, 4).
        width: Distance of the fingers when they grip [m].
        opening: Width of the hand while it approaches [m].
        clearance: Distance of the open hand from the object and from the points
            around it, at most `ENOUGH` [m].
        alignment: Cosine of the greatest angle between the closing axis and a
            normal at a gripped point.
        bearing: Fraction of a pad that presses on the object, 0 to 1: the
            smaller value of the two pads.
        lever: Distance of the centre of mass from the closing axis [m].
        score: Weighted quality, 0 to 1; larger is better.
    """

    X_OE: np.ndarray
    width: float
    opening: float
    clearance: float
    alignment: float
    bearing: float
    lever: float
    score: float = 0.0

    def flipped(self, gripper: ParallelGripper) -> "Grasp":
        """Returns the same grasp with the fingers exchanged.

        Args:
            gripper: The gripper.
        """
        a = gripper.approach_E
        turn = np.eye(4)
        turn[:3, :3] = 2.0 * np.outer(a, a) - np.eye(3)
        return dc.replace(self, X_OE=self.X_OE @ turn)

    def force(self, gripper: ParallelGripper, mass: float) -> float:
        """Returns the force with which each finger holds an object [N].

        Args:
            gripper: The gripper.
            mass: Mass of the object [kg].

        Raises:
            RemoSplatError: The hand is too weak.
        """
        return max(LEAST_FORCE, gripper.force(mass, GRIPPING, self.lever))


@dc.dataclass(frozen=True)
class Weights:
    """Weights of the terms of a grasp's score; their sum is 1.

    Attributes:
        clearance: Weight of the open hand's clearance.
        width: Weight of a narrow grasp, in which the fingers can close further.
        approach: Weight of the desired direction of approach.
        alignment: Weight of normals along the closing axis.
        bearing: Weight of the fraction of the pads that presses on the object.
        lever: Weight of a centre of mass near the closing axis.
    """

    clearance: float = 0.2
    width: float = 0.05
    approach: float = 0.2
    alignment: float = 0.1
    bearing: float = 0.25
    lever: float = 0.2


def plan_grasps(
    surface: Surface,
    gripper: ParallelGripper,
    *,
    friction: float = 0.5,
    approach_O: np.ndarray | None = None,
    around: np.ndarray | None = None,
    p_OOcm: np.ndarray | None = None,
    most: int = 60,
    weights: Weights = Weights(),
    rng: np.random.Generator,
) -> list[Grasp]:
    """Plans grasps of an object, the best first.

    Args:
        surface: The object's surface.
        gripper: The gripper.
        friction: Coefficient of friction of pads and object.
        approach_O: Desired direction of approach in O, shape (3,); None for
            any.
        around: Points of surrounding obstacles, in O, shape (m, 3) [m].
        p_OOcm: The centre of mass in O, shape (3,) [m]; None for the middle of
            the surface.
        most: Largest number of points of the surface whose antipodal partners
            are searched.
        weights: Weights of the score.
        rng: Source of randomness for the choice of points.

    Returns:
        Grasps whose open hand overlaps neither the object nor the points around
        it; none if the object is wider than the hand.
    """
    widest = gripper.max_width - 2.0 * LEAST_OPENING
    pairs = antipodal_pairs(surface, widest, friction, most, rng)
    solid = surface.points
    if around is not None:
        solid = np.concatenate([solid, around])
    middle = surface.points.mean(axis=0) if p_OOcm is None else p_OOcm
    solid, found = np.ascontiguousarray(solid), []
    for i in range(len(pairs)):
        width = float(pairs.width[i])
        opening = _opening(width, gripper.max_width)
        poses = grasp_poses(pairs.center[i], pairs.axis[i], gripper)
        clearances = hand_clearances(
            *gripper.pieces(opening), poses, solid, ENOUGH
        )
        alignment, lever = float(pairs.alignment[i]), _lever(pairs, i, middle)
        for X_OE, clearance in zip(poses, clearances, strict=True):
            if clearance > 0.0:
                grasp = Grasp(
                    X_OE,
                    width,
                    opening,
                    float(clearance),
                    alignment,
                    bearing(surface, gripper, X_OE, width),
                    lever,
                )
                score = _score(grasp, gripper, approach_O, weights)
                found.append(dc.replace(grasp, score=score))
    return sorted(found, key=lambda grasp: -grasp.score)


def grasp_poses(
    center: np.ndarray, axis: np.ndarray, gripper: ParallelGripper
) -> np.ndarray:
    """Lists the poses X_OE of a hand that closes along an axis, (k, 4, 4).

    Args:
        center: The point between the fingers, in O, shape (3,) [m].
        axis: The closing axis in O, shape (3,).
        gripper: The gripper.
    """
    hand = _frame(gripper.close_E, gripper.approach_E)
    aside = np.eye(3)[np.argmin(np.abs(axis))]
    first = np.cross(axis, aside)
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    poses = []
    for angle in 2.0 * np.pi * np.arange(APPROACHES) / APPROACHES:
        approach = np.cos(angle) * first + np.sin(angle) * second
        R_OE = _frame(axis, approach) @ hand.T
        for depth in DEPTHS:
            X_OE = np.eye(4)
            X_OE[:3, :3], X_OE[:3, 3] = R_OE, center - depth * approach
            poses.append(X_OE)
    return np.array(poses)


def bearing(
    surface: Surface, gripper: ParallelGripper, X_OE: np.ndarray, width: float
) -> float:
    """Returns the fraction of a pad that presses on an object, 0 to 1.

    A pad is divided into cells, one and a half times as large as the spacing of
    the surface's points. The fraction of a pad is the fraction of cells in
    which a point is within `GIVE` of the pad's plane. The result is the smaller
    fraction of the two pads. It is small if a hand holds an object only with
    its fingertips or at an edge; the object can then rotate in the hand.

    Args:
        surface: The object's surface.
        gripper: The gripper.
        X_OE: Pose of the end effector, shape (4, 4).
        width: Distance of the pads [m].
    """
    p_E = (surface.points - X_OE[:3, 3]) @ X_OE[:3, :3]
    lower, upper = gripper.pad
    counts = np.ceil((upper - lower) / (1.5 * surface.spacing))
    plane = p_E @ np.column_stack([gripper.approach_E, gripper.side_E])
    cell = np.floor((plane - lower) / (upper - lower) * counts)
    faces = ((cell >= 0) & (cell < counts)).all(axis=1)
    across = p_E @ gripper.close_E
    pressed = [
        len(
            np.unique(
                cell[faces & (side * across > 0.5 * width - GIVE)], axis=0
            )
        )
        for side in (-1.0, 1.0)
    ]
    return min(pressed) / float(np.prod(counts))


Reach = Callable[[np.ndarray, Grasp], np.ndarray | None]
"""Inverse kinematics: a function of a pose X_WE, shape (4, 4), and a grasp. It
returns a configuration, shape (n_q,), in which the end effector is at X_WE and
the robot, with its hand open as for the grasp, keeps all required distances;
None if there is none."""


def reachable(
    grasps: Sequence[Grasp],
    gripper: ParallelGripper,
    X_WO: np.ndarray,
    reach: Reach,
) -> Iterator[tuple[Grasp, np.ndarray]]:
    """Yields the grasps that the whole robot can reach, in their order.

    The function tries each grasp also with the fingers exchanged.

    Args:
        grasps: The grasps, the best first.
        gripper: The gripper.
        X_WO: Pose of the object, shape (4, 4).
        reach: Inverse kinematics of the robot with obstacles, see `Reach`.
    """
    for grasp in grasps:
        for each in (grasp, grasp.flipped(gripper)):
            q = reach(X_WO @ each.X_OE, each)
            if q is not None:
                yield each, q
                break


def _score(
    grasp: Grasp,
    gripper: ParallelGripper,
    approach_O: np.ndarray | None,
    weights: Weights,
) -> float:
    wanted = 1.0
    if approach_O is not None:
        a_O = grasp.X_OE[:3, :3] @ gripper.approach_E
        wanted = 0.5 + 0.5 * float(a_O @ approach_O)
    return (
        weights.clearance * grasp.clearance / ENOUGH
        + weights.width * (1.0 - grasp.width / gripper.max_width)
        + weights.approach * wanted
        + weights.alignment * grasp.alignment
        + weights.bearing * grasp.bearing
        + weights.lever * max(1.0 - grasp.lever / LEVER, 0.0)
    )


def _opening(width: float, widest: float) -> float:
    """Width of the hand before it grips, in whole millimetres if possible."""
    return min(np.ceil(1e3 * (width + 2.0 * OPENING)) / 1e3, widest)


def _lever(pairs: AntipodalPairs, i: int, p_OOcm: np.ndarray) -> float:
    off = p_OOcm - pairs.center[i]
    return float(np.linalg.norm(off - (off @ pairs.axis[i]) * pairs.axis[i]))


def _frame(close: np.ndarray, approach: np.ndarray) -> np.ndarray:
    return np.column_stack([close, approach, np.cross(close, approach)])
