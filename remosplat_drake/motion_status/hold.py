"""Finds causes that keep a robot from moving, and violated distances."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
import scipy

from remosplat_drake.motion_status.stillness import PAUSE, Stillness
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.pairs import self_collision_pairs
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.binding import (
    BOUND,
    COLLISION,
    JOINT_LIMIT,
    MOVER,
    SELF_COLLISION,
    Binding,
    BoundRow,
)
from remosplat_drake.signals.motion_status import (
    CONSTRAINT,
    NO_COMMAND,
    NOT_OBEYED,
    NOTHING,
    VERIFICATION,
)
from remosplat_drake.signals.near_movers import NearMovers
from remosplat_drake.signals.thing import Thing
from remosplat_drake.signals.tick_report import BRAKING, TickReport

_LEAST_PRESSURE = 1e-3
"""An active row whose pressure (see `pressures`) is below this value is not the
cause of a standstill, since the value may be a rounding error of the solver."""

_SHARE = 0.5
"""The sentence names the same link as the previous sentence if the pressure of
that link's row is at least this fraction of the greatest pressure. So the
sentence does not alternate between two rows of similar pressure."""

_VETO = 0.5
"""If verification multiplies the command by less than this factor, verification
is the cause that keeps the robot from moving."""

_LEAST_COMMAND = 0.03
"""Commanded speed above which a robot visibly moves [m/s, rad/s]."""

Naming = Callable[[np.ndarray], Thing]
"""Function that names the object at a point in W, shape (3,) [m]."""


@dc.dataclass(frozen=True, eq=False)
class Hold:
    """The cause that keeps a robot from moving.

    Attributes:
        cause: One of `motion_status.CAUSES`.
        thing: Name of the obstacle, joint or constraint.
        link: Name of the link that cannot move on; empty if the cause concerns
            no link.
        p_W: Point in W at which the link cannot move on, shape (3,) [m]; None
            if there is none.
        clearance: Distance from the link to the obstacle [m]; None if there is
            none.
    """

    cause: str
    thing: str = ""
    link: str = ""
    p_W: np.ndarray | None = None
    clearance: float | None = None

    @property
    def is_of_a_constraint(self) -> bool:
        """Whether the cause is an active constraint of the program."""
        return self.cause not in (NO_COMMAND, NOT_OBEYED, NOTHING)


def present_hold(
    still: Stillness,
    time: float,
    find: Callable[[], Hold],
    *,
    is_there: bool,
    lacks: bool,
) -> Hold | None:
    """Returns the cause that keeps a robot from moving; None while it moves.

    If the whole robot is at rest, the cause may be of any kind. If only its
    hand is at rest, the cause can only be a constraint or a missing path:
    otherwise the base may be turning for the next motion. If the robot moves
    but comes no nearer to its target, the cause can only be a mover, from which
    the robot may be moving away.

    Args:
        still: Past motion of the robot.
        time: Present time [s].
        find: Function that finds the cause.
        is_there: Whether the robot is at its target.
        lacks: Whether planning has found no path.
    """
    if time - still.robot.since >= PAUSE:
        return find()
    rests = time - still.hands.since >= PAUSE
    strays = not is_there and time - still.nearest_at >= PAUSE
    if not (rests or strays):
        return None
    hold = find()
    if rests and (hold.is_of_a_constraint or (lacks and hold.cause == NOTHING)):
        return hold
    return hold if strays and hold.cause == MOVER else None


def find_hold(
    report: TickReport, robot: RobotModel, name: Naming, link_before: str = ""
) -> Hold:
    """Finds the cause that keeps a robot from moving.

    Args:
        report: The report of the latest tick.
        robot: The robot.
        name: Function that names the object at a point.
        link_before: Name of the link in the previous cause.
    """
    if report.status == BRAKING:
        return Hold(NO_COMMAND, report.reason)
    row = _strongest(report, robot, link_before)
    if row is None:
        if report.objection and report.scale < _VETO:
            return _vetoed(report, robot, name)
        is_commanded = np.abs(report.command).max(initial=0.0) > _LEAST_COMMAND
        return Hold(NOT_OBEYED if is_commanded else NOTHING)
    return _of_row(row, report, robot, name)


def beside_mover(
    hold: Hold, robot: RobotModel, q: np.ndarray, movers: Movers, time: float
) -> Hold:
    """Adds the mover's point that is nearest to the waiting link.

    Args:
        hold: The cause that keeps the robot from moving. It is returned
            unchanged if it is not a mover.
        robot: The robot.
        q: Configuration of the robot, shape (n_q,) [m, rad].
        movers: The movers.
        time: Present time [s].
    """
    if hold.cause != MOVER:
        return hold
    spheres = robot.spheres_at(q)
    near = NearMovers.find(movers, time, spheres, np.inf)
    is_it = np.array([mover.name == hold.thing for mover in movers])
    pairs = robot.spheres.on_links({hold.link})[near.sphere]
    pairs &= is_it[near.mover]
    if not pairs.any():
        return hold
    i = int(np.where(pairs, near.distance, np.inf).argmin())
    s = near.sphere[i]
    way = spheres.radius[s] + near.distance[i]
    p_W = spheres.p_WS[s] + way * near.direction_W[i]
    return dc.replace(hold, p_W=p_W)


def find_inside(
    report: TickReport, robot: RobotModel, name: Naming
) -> Hold | None:
    """Finds the deepest violation of a stopping distance; None without one.

    Args:
        report: The report of the latest tick.
        robot: The robot.
        name: Function that names the object at a point.
    """
    if report.inside is None:
        return None
    return _of_row(report.inside, report, robot, name)


def _of_row(
    row: BoundRow, report: TickReport, robot: RobotModel, name: Naming
) -> Hold:
    if row.name == COLLISION:
        return _near(report, robot, name, row.index)
    if row.name == JOINT_LIMIT:
        return _at_limit(report, robot, row.about[0])
    if row.name == SELF_COLLISION:
        return _near_itself(report, robot, *row.about)
    if row.name == MOVER:
        link, mover = row.about
        return Hold(MOVER, mover, link)
    about = " and ".join(map(robot.description.called, row.about))
    return Hold(CONSTRAINT, f"{row.name} ({about})")


def pressures(binding: Binding) -> np.ndarray:
    """Computes the pressure of each active row, a measure of its effect.

    The pressure of a row is its multiplier at the program's optimum, times the
    norm of the row. The result has the shape (k,).

    Args:
        binding: The k rows that hold with equality.
    """
    if not len(binding.A):
        return np.zeros(0)
    length = np.linalg.norm(binding.A, axis=1)
    length = np.where(length > 0, length, 1.0)
    return scipy.optimize.nnls((binding.A / length[:, None]).T, binding.push)[0]


def _strongest(
    report: TickReport, robot: RobotModel, link_before: str
) -> BoundRow | None:
    """Returns the row that the sentence names; None if no row has pressure."""
    rows = report.binding.rows
    pressed = pressures(report.binding)
    pressed[[row.name == BOUND for row in rows]] = 0.0
    if pressed.max(initial=0.0) < _LEAST_PRESSURE:
        return None
    least = _SHARE * pressed.max()
    for i in np.argsort(-pressed).tolist():
        if pressed[i] < least:
            break
        if _link(rows[i], report, robot) == link_before:
            return rows[i]
    return rows[int(pressed.argmax())]


def _link(row: BoundRow, report: TickReport, robot: RobotModel) -> str:
    """Returns the name of the link that a row constrains; empty if none."""
    if row.name == COLLISION:
        return robot.spheres.links[report.clearances.sphere[row.index]]
    if row.name in (SELF_COLLISION, MOVER):
        return row.about[0]
    if row.name == JOINT_LIMIT:
        return moved_by(robot, row.about[0])
    return ""


def nearest_hold(
    report: TickReport, robot: RobotModel, name: Naming, cause: str
) -> Hold:
    """Returns a `Hold` whose obstacle is the nearest one in the scene.

    Args:
        report: The report of the latest tick, with at least one clearance.
        robot: The robot.
        name: Function that names the object at a point.
        cause: The cause, one of `motion_status.CAUSES`.
    """
    nearest = int(report.clearances.distance.argmin())
    return dc.replace(_near(report, robot, name, nearest), cause=cause)


def _near(report: TickReport, robot: RobotModel, name: Naming, i: int) -> Hold:
    """Returns a `Hold` whose obstacle is that of row i of the clearances."""
    clearances = report.clearances
    link = robot.spheres.links[clearances.sphere[i]]
    p_WC, distance = clearances.p_WC[i], float(clearances.distance[i])
    thing = name(p_WC)
    return Hold(thing.kind, thing.name, link, p_WC, distance)


def _vetoed(report: TickReport, robot: RobotModel, name: Naming) -> Hold:
    """Returns a `Hold` for the constraint that verification has reported."""
    separation = report.separation
    if report.objection == MOVER and separation is not None:
        return Hold(MOVER, separation.mover, separation.link)
    if report.objection != COLLISION or not len(report.clearances):
        before = {
            JOINT_LIMIT: "a joint's limit",
            SELF_COLLISION: "the robot itself",
        }
        return Hold(VERIFICATION, before.get(report.objection, "the scene"))
    return nearest_hold(report, robot, name, VERIFICATION)


def _at_limit(report: TickReport, robot: RobotModel, joint: str) -> Hold:
    k = robot.joint_names.index(joint)
    to_lower = report.q[k] - robot.position_lower[k]
    to_upper = robot.position_upper[k] - report.q[k]
    side = "lower" if to_lower < to_upper else "upper"
    link = moved_by(robot, joint)
    p_W = robot.body_poses(report.q)[robot.tree.index(link), :3, 3]
    thing = f"the {side} limit of {robot.description.called(joint)}"
    return Hold(JOINT_LIMIT, thing, link, p_W)


def moved_by(robot: RobotModel, joint: str) -> str:
    """Returns the name of the first link that a joint moves.

    Args:
        robot: The robot.
        joint: Name of the joint.
    """
    k = robot.joint_names.index(joint)
    return robot.tree.names[int(np.argmax(robot.tree.position == k))]


def _near_itself(
    report: TickReport, robot: RobotModel, link: str, other: str
) -> Hold:
    # The link nearer to the arm's end is the one that cannot move on, and the
    # other link is the obstacle.
    if robot.tree.index(other) > robot.tree.index(link):
        link, other = other, link
    thing = f"the {robot.description.called(other)}"
    pairs = self_collision_pairs(robot, 0.0)
    near = pairs.near(robot.body_poses(report.q), np.inf)
    distance = near.distance - pairs.allowance[near.pair]
    between = {link, other}
    distance[[set(pairs.links(p)) != between for p in near.pair]] = np.inf
    if not np.isfinite(distance).any():
        return Hold(SELF_COLLISION, thing, link)
    i = int(distance.argmin())
    is_first = pairs.links(int(near.pair[i]))[0] == link
    p_W = near.p_WA[i] if is_first else near.p_WB[i]
    return Hold(SELF_COLLISION, thing, link, p_W, float(distance[i]))
