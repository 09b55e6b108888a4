"""Arrays with the inputs of ingredients at a tick, and with their terms."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import named, reals, truths, wholes
from remosplat_drake.base.vectors import set_vector
from remosplat_drake.controller.program.servo import error_scale
from remosplat_drake.robot.braking import HELD
from remosplat_drake.robot.robot_arrays import (
    RobotArrays,
    StateArrays,
    add_rate,
)
from remosplat_drake.robot.self_collision.kernels.near_points import (
    near_points,
)
from remosplat_drake.robot.self_collision.pair_arrays import PairArrays
from remosplat_drake.robot.target_arrays import (
    AimArrays,
    constrained_error,
    target_of,
)
from remosplat_drake.scene.kernels.mover_reach import (
    NearMoverArrays,
    moved_on,
    near_movers,
)


class GuidanceArrays(NamedTuple):
    """A `Guidance`, packed for kernels.

    Attributes:
        side: `Guidance.side`.
        bearing: `Guidance.bearing` [rad].
        active_scale: `Guidance.active_scale`.
        stopping: `Guidance.stopping` [m]; NaN keeps the configured one.
        approach_scale: `Guidance.approach_scale`.
        joint_stop: `Guidance.joint_stop` [rad]; NaN keeps the configured one.
        slide_stop: `Guidance.slide_stop` [m]; NaN keeps the configured one.
        path_q: Corners of `Guidance.path`, shape (k, n_q); empty if there is no
            path.
        path_s: Arc length at each corner, shape (k,).
        path_v: `Path.v`, shape (k,) [1/s]; empty for a path without speeds.
        path_a: `Path.a`, shape (k, 2) [1/s^2]; empty for a path without speeds.
    """

    side: float
    bearing: float
    active_scale: float
    stopping: float
    approach_scale: float
    joint_stop: float
    slide_stop: float
    path_q: np.ndarray
    path_s: np.ndarray
    path_v: np.ndarray
    path_a: np.ndarray


class NearSettings(NamedTuple):
    """Settings of the search for links that are near each other.

    Attributes:
        pairs: The pairs of shapes.
        reach: Distance up to which links are searched [m]; negative for no
            search.
        crowded: Distance of two links below which all pairs of their shapes are
            returned, and not only the nearest pair [m].
    """

    pairs: PairArrays
    reach: float
    crowded: float


class NearArrays(NamedTuple):
    """Nearest points of m pairs of links, packed for kernels.

    Attributes:
        pair: Index of the pair of shapes, shape (m,).
        body_A: Body of the point on the first link, shape (m,).
        body_B: Body of the point on the second link, shape (m,).
        distance: `NearPoints.distance`.
        normal_W: `NearPoints.normal_W`.
        p_WA: `NearPoints.p_WA`.
        p_WB: `NearPoints.p_WB`.
    """

    pair: np.ndarray
    body_A: np.ndarray
    body_B: np.ndarray
    distance: np.ndarray
    normal_W: np.ndarray
    p_WA: np.ndarray
    p_WB: np.ndarray


class OutsideRows(NamedTuple):
    """The rows and tracked twists of ingredients in Python.

    Attributes:
        rows: The rows A u <= b of these ingredients, each as the entries of A
            and then b, shape (m, n_u + 1).
        tracked: The tracked directions of twists, shape (r, n_u + 3). Each has
            a row of the Jacobian, the twist, the bound of its slack, and the
            weight of the slack.
    """

    rows: np.ndarray
    tracked: np.ndarray


class OutsideArrays(NamedTuple):
    """All terms that ingredients in Python have added to a program.

    Attributes:
        bounds: `ProgramArrays.lower`, `upper`, `free_lower` and `free_upper`
            with the bounds of these ingredients, shape (4, n_u).
        costs: Vector of the linear costs of these ingredients, and diagonal of
            their quadratic costs, shape (2, n_u).
        flags: Two flags, shape (2,), bool: whether some bounds are acceleration
            bounds, and whether Drake's program may have further terms.
        more: The rows and the tracked twists of these ingredients.
    """

    bounds: np.ndarray
    costs: np.ndarray
    flags: np.ndarray
    more: OutsideRows


class TickArrays(NamedTuple):
    """A `Tick`, packed for kernels.

    Attributes:
        robot: The robot.
        state: Kinematics at the measured configuration.
        aim: The k targets of the end effectors.
        p_ET_W: `PoseError.p_ET_W` of each target, shape (k, 3) [m].
        rotation_W: `PoseError.rotation_W` of each target, shape (k, 3) [rad].
        error_scales: `Tick.error_scales`, shape (k,) [m].
        error_scale: `Tick.error_scale` [m].
        sphere: Indices of the spheres that have the m clearances, shape (m,).
        distance: The clearances, shape (m,) [m].
        direction_W: Directions towards the scene, shape (m, 3).
        rates: `Tick.approach_rates`, shape (m, n_u).
        moving: Pairs of a sphere and a near mover, for the mover damper.
        soon: Pairs of a sphere and a near mover after the look-ahead time of
            the active collision cost.
        near: Points at which links are near each other.
        u_previous: The command that is being executed, shape (n_u,).
        dt: Control period [s].
        tube: Bound of each sphere's deviation from its path, shape (n,) [m].
        guidance: The guidance.
    """

    robot: RobotArrays
    state: StateArrays
    aim: AimArrays
    p_ET_W: np.ndarray
    rotation_W: np.ndarray
    error_scales: np.ndarray
    error_scale: float
    sphere: np.ndarray
    distance: np.ndarray
    direction_W: np.ndarray
    rates: np.ndarray
    moving: NearMoverArrays
    soon: NearMoverArrays
    near: NearArrays
    u_previous: np.ndarray
    dt: float
    tube: np.ndarray
    guidance: GuidanceArrays


class ProgramArrays(NamedTuple):
    """The quadratic program of a tick, with the terms of k ingredients.

    The order of the ingredients is: those of the library, a user's compiled
    ingredients, and as the last of the k entries all ingredients in Python.

    Attributes:
        lower: Lower bounds on u, shape (n_u,).
        upper: Upper bounds on u, shape (n_u,).
        free_lower: Lower bounds on u without acceleration bounds, shape (n_u,).
        free_upper: Upper bounds on u without acceleration bounds, shape (n_u,).
        linear: Vectors c of the ingredients' linear costs, shape (k, n_u).
        quadratic: Diagonals of the ingredients' quadratic costs, shape (k,
            n_u).
        has: Whether each ingredient has a linear cost, and whether it has a
            quadratic cost, shape (k, 2), bool.
        A: Coefficients of rows A u <= b, shape (most, n_u). Rows for which
            there is no space are written to the last row, which is ignored.
        b: Right-hand sides of the rows, shape (most,).
        kept: Whether each row is not implied by the bounds of u, shape (most,),
            bool.
        raised: Whether each row is relaxed, so that its negative right-hand
            side is raised, shape (most,), bool.
        about: Subject of each row, such as the index of a sphere or a joint,
            shape (most,).
        rows: Index of each ingredient's first row, and the index after its last
            row, shape (k, 2).
        J: Jacobian of the tracked twists, one row for each tracked direction,
            shape (6 e, n_u) for e end effectors.
        V: The tracked twists, shape (6 e,) [rad/s, m/s].
        limit: Bounds of the slack of the tracked twists, shape (6 e,) [rad/s,
            m/s].
        price: Weight of the squared slack, shape (6 e,).
        tracked: Cumulative number of tracked rows up to each end effector,
            shape (e,).
        count: Six integers, shape (6,): the number of rows; the number of the
            ingredient that tracks twists plus one, or 0 if there is none;
            whether there are acceleration bounds; the number of tracked
            directions; whether every u within the bounds violates some row; and
            whether Drake's program has further terms.
    """

    lower: np.ndarray
    upper: np.ndarray
    free_lower: np.ndarray
    free_upper: np.ndarray
    linear: np.ndarray
    quadratic: np.ndarray
    has: np.ndarray
    A: np.ndarray
    b: np.ndarray
    kept: np.ndarray
    raised: np.ndarray
    about: np.ndarray
    rows: np.ndarray
    J: np.ndarray
    V: np.ndarray
    limit: np.ndarray
    price: np.ndarray
    tracked: np.ndarray
    count: np.ndarray


PROGRAM = named(
    ProgramArrays,
    *(reals(1), reals(1), reals(1), reals(1), reals(2), reals(2), truths(2)),
    *(reals(2), reals(1), truths(1), truths(1), wholes(1), wholes(2), reals(2)),
    *(reals(1), reals(1), reals(1), wholes(1), wholes(1)),
)
"""Numba's type of a program."""

_NEAR = named(
    NearArrays,
    *(wholes(1), wholes(1), wholes(1)),
    *(reals(1), reals(2), reals(2), reals(2)),
)


@kernel(returns=_NEAR)
def near_arrays(near, X_WL) -> NearArrays:
    """Finds the points at which the robot's links are near each other.

    Args:
        near: The `NearSettings`, packed.
        X_WL: Poses of all bodies, shape (b, 4, 4).
    """
    pairs = near.pairs
    pair, distance, normal_W, p_WA, p_WB = near_points(
        pairs, X_WL, near.reach, near.crowded
    )
    first, second, body = pairs.first, pairs.second, pairs.shapes.body
    body_A, body_B = np.empty_like(pair), np.empty_like(pair)
    for i in range(len(pair)):
        body_A[i], body_B[i] = body[first[pair[i]]], body[second[pair[i]]]
    return NearArrays(pair, body_A, body_B, distance, normal_W, p_WA, p_WB)


@helper
def find_movers(movers, p_WS, radius, within, dt, lead, within_soon):
    """Finds movers near the robot, now and after a look-ahead time.

    Verification requires that a moving sphere does not approach a mover while
    the station executes one command. So the present distances are those from
    all places that the movers can reach in this time.

    Args:
        movers: The `MoverArrays`.
        p_WS: Centres of the spheres, shape (n, 3) [m].
        radius: Radii of the spheres, shape (n,) [m].
        within: Distance at or beyond which pairs are omitted, for the present
            places of movers [m].
        dt: Control period [s].
        lead: The look-ahead time [s].
        within_soon: Distance at or beyond which pairs are omitted, for the
            places of movers after the look-ahead time [m].
    """
    return (
        near_movers(movers, p_WS, radius, within, HELD * dt),
        near_movers(
            moved_on(movers, lead, lead), p_WS, radius, within_soon, 0.0
        ),
    )


@helper
def make_tick(
    robot, state, aim, rows, movers, near, u_previous, dt, tube, guidance
) -> TickArrays:
    """Makes the `TickArrays` of a tick.

    Args:
        robot: The `RobotArrays`.
        state: The `StateArrays`.
        aim: The `AimArrays`.
        rows: Spheres, distances and directions of the clearances.
        movers: `TickArrays.moving` and `TickArrays.soon`.
        near: The `NearArrays`.
        u_previous: The command that is being executed, shape (n_u,).
        dt: Control period [s].
        tube: Bound of each sphere's deviation from its path, shape (n,) [m].
        guidance: The `GuidanceArrays`.
    """
    sphere, distance, direction_W = rows
    moving, soon = movers
    k = len(aim.effector)
    p_ET_W, rotation_W = np.empty((k, 3)), np.empty((k, 3))
    scales, largest = np.empty(k), 0.0
    for i in range(k):
        target = target_of(aim, i)
        p_W, turn_W, p_E = constrained_error(
            state.X_WE[aim.effector[i]], target
        )
        set_vector(p_ET_W[i], p_W)
        set_vector(rotation_W[i], turn_W)
        scales[i] = error_scale(p_E, target)
        largest = max(largest, scales[i])
    rates = np.zeros((len(sphere), len(u_previous)))
    for i in range(len(sphere)):
        s = sphere[i]
        body, p_WS = robot.body_S[s], state.p_WS[s]
        add_rate(robot, state, body, p_WS, direction_W[i], 1.0, rates[i])
    return TickArrays(
        robot,
        state,
        aim,
        p_ET_W,
        rotation_W,
        scales,
        largest,
        sphere,
        distance,
        direction_W,
        rates,
        moving,
        soon,
        near,
        u_previous,
        dt,
        tube,
        guidance,
    )


@helper
def make_program(velocity_limit, n_effectors, n_parts, most) -> ProgramArrays:
    """Makes a program without terms.

    Args:
        velocity_limit: Initial bounds of |u|, shape (n_u,).
        n_effectors: Number of end effectors.
        n_parts: Number of ingredients.
        most: Largest total number of rows that the ingredients add.
    """
    n_u, tracked, most = len(velocity_limit), 6 * n_effectors, most + 1
    return ProgramArrays(
        -velocity_limit,
        velocity_limit.copy(),
        -velocity_limit,
        velocity_limit.copy(),
        np.zeros((n_parts, n_u)),
        np.zeros((n_parts, n_u)),
        np.zeros((n_parts, 2), np.bool_),
        np.zeros((most, n_u)),
        np.empty(most),
        np.zeros(most, np.bool_),
        np.zeros(most, np.bool_),
        np.empty(most, np.int64),
        np.zeros((n_parts, 2), np.int64),
        np.zeros((tracked, n_u)),
        np.zeros(tracked),
        np.zeros(tracked),
        np.zeros(tracked),
        np.zeros(n_effectors, np.int64),
        np.zeros(6, np.int64),
    )


@helper
def narrow(program, lower, upper, is_acceleration) -> None:
    """Bounds u by lower <= u <= upper, in addition to the present bounds.

    Args:
        program: The `ProgramArrays`.
        lower: Further lower bounds, shape (n_u,).
        upper: Further upper bounds, shape (n_u,).
        is_acceleration: Whether the new bounds are acceleration bounds, which
            may be dropped.
    """
    for j in range(len(lower)):
        program.lower[j] = max(program.lower[j], lower[j])
        program.upper[j] = min(program.upper[j], upper[j])
        if not is_acceleration:
            program.free_lower[j] = max(program.free_lower[j], lower[j])
            program.free_upper[j] = min(program.free_upper[j], upper[j])
    if is_acceleration:
        program.count[2] = 1


@helper
def new_row(program, k, b, about):
    """Adds a row 0 u <= b of ingredient k, and returns its index in `A`.

    The functions of compiled ingredients call `new_row`; see
    `CompiledIngredient`.

    Args:
        program: The `ProgramArrays`.
        k: Number of the calling ingredient.
        b: Right-hand side.
        about: Number of the row's subject, which the ingredient's method
            `about` takes.

    Example:
        >>> import remosplat_drake as rs
        >>> from typing import NamedTuple
        >>> class Limit(NamedTuple):
        ...     speed: float
        >>> class SlowElbow(rs.CompiledIngredient):
        ...     term = "slow elbow"
        ...     def settings(self, robot):
        ...         return Limit(0.1)
        ...     def most_rows(self, robot):
        ...         return 1
        ...     @staticmethod
        ...     def add(own, k, tick, program):
        ...         row = rs.new_row(program, k, own.speed, 0)
        ...         program.A[row, tick.robot.n_base + 3] = 1.0
        >>> law = rs.ReactiveLaw(rs.load_robot("frankie"), [SlowElbow()])
    """
    count = program.count[0]
    if program.rows[k, 1] == 0:
        program.rows[k, 0] = count
    program.count[0] = program.rows[k, 1] = count + 1
    i = min(count, len(program.b) - 1)
    program.b[i], program.about[i] = b, about
    return i


@helper
def given_or(value, default) -> float:
    """Returns a value of guidance, or the configured value if it is NaN.

    Args:
        value: Value of guidance.
        default: Configured value.
    """
    return default if np.isnan(value) else value
