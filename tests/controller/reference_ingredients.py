"""The library's ingredients, slow and readable, in Python.

What runs is each ingredient's compiled function; tests hold it against this.
"""

import math
from collections.abc import Callable

import numpy as np

from remosplat_drake.controller import ingredients as ing
from remosplat_drake.controller.ingredients.deflection import NEAR
from remosplat_drake.controller.ingredients.manipulability_cost import (
    manipulability,
)
from remosplat_drake.controller.ingredients.servo_tracking import (
    LAST_DRIVE,
    LAST_STRETCH,
)
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.program.ingredient import AnyIngredient
from remosplat_drake.controller.program.joint_margins import (
    STOP_SHARE,
    joint_margins,
)
from remosplat_drake.controller.program.path import Path
from remosplat_drake.controller.program.program_terms import tracking_name
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.servo import (
    LINE_STIFFNESS,
    target_twist,
)
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.robot.braking import HELD
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.pairs import (
    NearPoints,
    SelfCollisionPairs,
)
from remosplat_drake.robot.target_arrays import place_on_line
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.target import Target

TURNING = 1e-9
"""Way of the base below which a stretch of the path only turns it [m]."""

SHORTEST_PURSUIT = 0.2
"""Least distance at which a base steers for a place [m]."""

REACHED, CREEP = 0.02, 0.3
"""What counts as reached on a path, and the speed that no row slows down."""

LAST_MARGIN, LAST_SLOPE = 0.005, 2.1
"""Margin in which the damper's slope is bounded [m], and by what [1/s]."""

PASSED = 0.05
"""Depth at the target at which an obstacle counts in full [m]."""


def add_reference(
    part: AnyIngredient, program: ReactiveProgram, tick: Tick
) -> None:
    """Adds an ingredient's terms: by the function below, or by its own."""
    if isinstance(part, CompiledIngredient):
        REFERENCE[type(part)](part, program, tick)
    else:
        part.AddToProgram(program, tick)


def _servo_tracking(
    own: ing.ServoTracking, program: ReactiveProgram, tick: Tick
) -> None:
    """Sets the twists that are tracked, and the slack's bounds and price."""
    if tick.aim.q is not None:
        return
    path = tick.guidance.path
    last = LAST_DRIVE if tick.robot.n_base == 2 else LAST_STRETCH
    if path is not None and path.length - path.nearest(tick.state.q)[0] > last:
        return
    limit = own._config.slack_limit
    for k, (effector, target) in enumerate(tick.aim.items):
        w, v, along_W = _twist(own, tick, k, effector, target)
        rows = _tracked_directions(target, along_W)
        V = rows @ np.concatenate([w, v])
        # Standing still must stay feasible, however fast the servo's twist.
        program.track(
            tracking_name(own.term, tick.robot.effectors[effector]),
            J=rows @ tick.state.J_WE(effector),
            V=V,
            price=1.0 / tick.error_scales[k],
            limit=np.maximum(limit, np.abs(V)),
        )


def _twist(
    own: ing.ServoTracking, tick: Tick, k: int, effector: int, target: Target
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The twist to a target, and the direction of its line, (3,) each."""
    config, error = own._config, tick.errors[k]
    X_WE = tick.state.X_WEs[effector]
    w, v = target_twist(X_WE, target, error, config.gain, config.fastest)
    if target.line is not None:
        return w, v, place_on_line(X_WE.copy(), target.arrays)[0]
    v = _deflected_velocity(
        v,
        error,
        tick.clearances,
        tick.robot.hands[effector],
        tick.guidance,
        own._damper.stopping_for(tick.guidance),
        config.fastest,
    )
    return w, v, np.zeros(3)


def _velocity_cost(
    own: ing.VelocityCost, program: ReactiveProgram, tick: Tick
) -> None:
    """Adds the cost of the squared command."""
    weights = np.full(program.n_u, own._config.weight)
    error = tick.error_scale if tick.aim.q is None else 100.0
    weights[: tick.robot.n_base] /= error
    program.add_quadratic_cost(own.term, weights)


def _velocity_limits(
    own: ing.VelocityLimits, program: ReactiveProgram, tick: Tick
) -> None:
    """Narrows the bounds on u."""
    upper = own.config.fraction * tick.robot.velocity_limit
    lower = -upper
    n = tick.robot.n_base
    base_lower, base_upper = own.config.base_bounds(n)
    lower[:n] = np.maximum(lower[:n], base_lower)
    upper[:n] = np.minimum(upper[:n], base_upper)
    program.narrow(lower, upper)
    if own.config.acceleration:
        limit = own.config.fraction * tick.robot.acceleration_limit
        step = limit * tick.dt
        # A previous command outside the limits (their fraction may have
        # changed) must not turn the box inside out.
        anchor = np.clip(tick.u_previous, lower, upper)
        program.narrow(anchor - step, anchor + step, acceleration=True)


def _joint_limit_damper(
    own: ing.JointLimitDamper, program: ReactiveProgram, tick: Tick
) -> None:
    """Adds a row for each joint of the arm near one of its limits."""
    robot, config = tick.robot, own._config
    n_arm = robot.n_u - robot.n_base
    arm = slice(robot.n_q - n_arm, robot.n_q)
    q = tick.state.q[arm]
    rho = np.concatenate(
        [robot.position_upper[arm] - q, q - robot.position_lower[arm]]
    )
    influence = config.influence_of(robot)
    near = np.flatnonzero(rho < np.tile(influence, 2))
    if not len(near):
        return
    joint = near % n_arm
    A = np.zeros((len(near), robot.n_u))
    A[np.arange(len(near)), robot.n_base + joint] = np.where(
        near < n_arm, 1.0, -1.0
    )
    stop = _stop_of(config, robot, tick.guidance)
    gain = np.where(robot.arm_turns, config.gain, config.slide_gain)
    b = (gain / (influence - stop))[joint] * (rho[near] - stop[joint])

    def label(i: int) -> str:
        return own.about(robot, None, joint[i])

    program.add_rows(own.term, A, b, label)


def _collision_damper(
    own: ing.CollisionDamper, program: ReactiveProgram, tick: Tick
) -> None:
    """Adds a row for every clearance within the influence distance."""
    config, clearances = own.config, tick.clearances
    if not len(clearances):
        return
    stopping = config.stopping_for(tick.guidance)
    margin = clearances.distance - stopping
    if tick.sphere_tube is not None:
        margin = margin - tick.sphere_tube[clearances.sphere]
    scale = tick.guidance.approach_scale
    slope = scale * config.gain / (config.influence - stopping)
    last = np.minimum(margin, LAST_MARGIN)
    last_slope = slope
    if tick.guidance.path is None:
        last_slope = min(slope, LAST_SLOPE)
    b = slope * (margin - last) + last_slope * last
    b = np.minimum(b, np.maximum(margin, 0.0) / tick.dt)
    if slope > LAST_SLOPE:
        braking = np.abs(tick.approach_rates) @ tick.robot.acceleration_limit
        fastest = np.sqrt(braking * np.maximum(margin, 0.0))
        kept = np.minimum(b, fastest) if last_slope < slope else b
        approach = tick.approach_rates @ tick.u_previous
        kept = np.maximum(kept, approach - 0.9 * braking * tick.dt)
        b = np.where(margin > 0.0, kept, b)
    moves = tick.approach_rates.any(axis=1)
    b = np.where(moves, b, np.maximum(b, 0.0))

    def label(i: int) -> str:
        return own.about(tick.robot, None, clearances.sphere[i])

    program.add_rows(own.term, tick.approach_rates, b, label)


def _self_collision_damper(
    own: ing.SelfCollisionDamper, program: ReactiveProgram, tick: Tick
) -> None:
    """Adds the rows of link pairs within the influence distance."""
    config, pairs = own.config, own._pairs
    if not (config.enabled and len(pairs)):
        return
    near = pairs.near(tick.state.X_WL, config.influence, 1.2 * config.stopping)
    if not len(near):
        return
    first, second = bodies_of(pairs, near)
    relative = tick.state.point_jacobians(first, near.p_WA)
    relative -= tick.state.point_jacobians(second, near.p_WB)
    A = np.matvec(np.swapaxes(relative, 1, 2), near.normal_W)
    span = config.influence - config.stopping
    b = config.gain * (near.distance - config.stopping) / span

    def label(i: int) -> tuple[str, str]:
        return own.about(tick.robot, None, near.pair[i])

    program.add_rows(own.term, A, b, label)


def _active_collision_cost(
    own: ing.ActiveCollisionCost, program: ReactiveProgram, tick: Tick
) -> None:
    """Adds the cost, if anything is within the influence distance."""
    clearances, movers = tick.clearances, own._movers
    gain = own._gain * tick.guidance.active_scale
    soon = tick.near_movers(movers.influence, own._lead)
    if gain == 0.0 or not len(clearances) + len(soon):
        return
    influence = own._damper.influence
    span = influence - own._damper.stopping_for(tick.guidance)
    room = movers.influence - movers.separation
    w = np.concatenate(
        [
            (influence - clearances.distance) / span,
            (movers.influence - soon.distance) / room,
        ]
    )
    rates = soon.approach_rates(tick.state.Jv_WS)
    mean = w @ np.concatenate([tick.approach_rates, rates]) / w.sum()
    program.add_linear_cost(own.term, gain * w.max() ** 2 * mean)


def _manipulability_cost(
    own: ing.ManipulabilityCost, program: ReactiveProgram, tick: Tick
) -> None:
    """Adds the cost on the arm's joint velocities."""
    if own._gain == 0.0 or tick.guidance.path is not None:
        return
    arm = slice(tick.robot.n_base, None)
    c = np.zeros(program.n_u)
    for effector, _ in tick.aim.items:
        J = tick.state.J_WE(effector)[:, arm]
        _, gradient = manipulability(J[:3].copy(), J[3:].copy())
        c[arm] -= own._gain * gradient
    program.add_linear_cost(own.term, c)


def _base_orientation_cost(
    own: ing.BaseOrientationCost, program: ReactiveProgram, tick: Tick
) -> None:
    """Adds the cost on the yaw rate."""
    if own._gain == 0.0 or tick.robot.n_base == 0:
        return
    if tick.guidance.path is not None:
        return
    X_WB = tick.state.X_WB
    aimed = [i for i, _ in tick.aim.items]
    p_WE = tick.state.X_WEs[aimed, :3, 3].mean(axis=0)
    p_BE_B = X_WB[:3, :3].T @ (p_WE - X_WB[:3, 3])
    c = np.zeros(program.n_u)
    theta = math.atan2(p_BE_B[1], p_BE_B[0])
    c[tick.robot.n_base - 1] = -own._gain * (theta - tick.guidance.bearing)
    program.add_linear_cost(own.term, c)


def _path_tracking(
    own: ing.PathTracking, program: ReactiveProgram, tick: Tick
) -> None:
    """Adds the cost of leaving the path."""
    path = tick.guidance.path
    if path is None:
        return
    u = _path_velocity(path, tick, own._config, program)
    weights = np.full(program.n_u, own._config.weight)
    program.add_quadratic_cost(own.term, weights)
    program.add_linear_cost(own.term, -weights * u)


def _mover_damper(
    own: ing.MoverDamper, program: ReactiveProgram, tick: Tick
) -> None:
    """Adds a row for every sphere and mover near each other."""
    config = own.config
    near = tick.near_movers(config.influence, by=HELD * tick.dt)
    if not len(near):
        return
    margin = near.distance - config.separation
    if tick.sphere_tube is not None:
        margin = margin - tick.sphere_tube[near.sphere]
    b = config.gain * margin / (config.influence - config.separation)
    n = len(tick.robot.spheres)

    def label(i: int) -> tuple[str, str]:
        number = near.mover[i] * n + near.sphere[i]
        return own.about(tick.robot, tick.movers, number)

    rates = near.approach_rates(tick.state.Jv_WS)
    program.add_rows(own.term, rates, b - near.closing, label)


def _path_velocity(
    path: Path,
    tick: Tick,
    config: ing.PathTrackingConfig,
    program: ReactiveProgram,
) -> np.ndarray:
    """Computes the command that leads along a path, shape (n_u,).

    A differential base does not look beyond the corner at which it goes over
    from turning to driving or back, and slows down before it.

    Args:
        path: The path.
        tick: What is known at the tick; configuration and limits matter.
        config: Speed and how far ahead the robot aims.
        program: The rows and bounds so far.
    """
    robot, q = tick.robot, tick.state.q
    s, apart = path.nearest(q)
    left, corner = path.length - s + apart, path.length
    if robot.n_base == 2:
        corner = _next_corner(path, s, REACHED)
        left = min(left, corner - s + REACHED)
    way, speed = 0.0, config.gain * left
    if path.v is not None:
        way = way_in(path, s, tick.dt)
        speed = max(way / tick.dt, config.gain * min(left, REACHED))
    goal = min(s + max(config.look_ahead, way), corner)
    e = path.at(goal) - q
    along = e
    if robot.n_base == 2:
        along = _unicycle(path, goal, q, e)
    elif robot.n_base:
        along = robot.velocity_map(q).T @ e
    size = float(np.linalg.norm(along))
    if size < 1e-9:
        return np.zeros(robot.n_u)
    along = along / size
    fastest = np.linalg.norm(tick.state.Jv_WS @ along, axis=1).max(initial=0.0)
    if config.max_speed is not None:
        speed = min(speed, config.max_speed / max(float(fastest), 1e-9))
    if path.v is not None and path.a is not None:
        now = max(float(along @ tick.u_previous), 0.0)
        k = min(int(np.searchsorted(path.s, s, "right")) - 1, len(path.s) - 1)
        share = min((now / max(path.v[k], 1e-9)) ** 2, 1.0)
        at_rest, at_speed = path.a[k]
        change = at_rest + share * (at_speed - at_rest)
        speed = min(speed, now + float(change) * tick.dt)
    return _speed_within(program, along, speed) * along


def way_in(path: Path, s: float, time: float) -> float:
    """Finds how far a path's speeds lead in a time, from the time they take."""
    least, most = s, path.length
    if time_between(path, s, most) <= time:
        return most - s
    while most - least > 1e-14:
        middle = 0.5 * (least + most)
        if not least < middle < most:
            break
        if time_between(path, s, middle) <= time:
            least = middle
        else:
            most = middle
    return least - s


def time_between(path: Path, start: float, end: float) -> float:
    """Returns the time from one place on a path to another [s]."""
    assert path.v is not None
    inside = path.s[(path.s > start) & (path.s < end)]
    s = np.concatenate([[start], inside, [end]])
    v = np.sqrt(np.interp(s, path.s, path.v**2))
    with np.errstate(divide="ignore", invalid="ignore"):
        # On each piece dv/dt is constant: the mean speed is the ends' mean.
        times = 2.0 * np.diff(s) / (v[1:] + v[:-1])
    return float(np.where(np.diff(s) > 0.0, times, 0.0).sum())


def _speed_within(
    program: ReactiveProgram, along: np.ndarray, speed: float
) -> float:
    """Bounds the speed along a direction by the rows and bounds so far."""
    for rows in program.terms.rows.values():
        for rate, b in zip(rows.A @ along, rows.b, strict=True):
            if rate > 1e-9:
                speed = min(speed, max(b / rate, CREEP))
    least, most = 0.0, math.inf
    for a, lower, upper in zip(
        along, program.lower, program.upper, strict=True
    ):
        slow, fast = (lower, upper) if a > 0.0 else (-upper, -lower)
        if abs(a) > 1e-9 and fast > 0.0:
            least, most = max(least, slow / abs(a)), min(most, fast / abs(a))
    return min(max(speed, least), most)


def _drives(path: Path) -> np.ndarray:
    """Tells on which stretches of a path the base drives, shape (k,)."""
    return np.hypot(*np.diff(path.q[:, :2], axis=0).T) > TURNING


def _next_corner(path: Path, s: float, reached: float) -> float:
    """Returns where the base next goes over from turning to driving or back.

    A corner that is nearer than `reached` lies behind.
    """
    drives = _drives(path)
    changes = path.s[1:-1][drives[1:] != drives[:-1]]
    ahead = changes[changes > s + reached]
    return float(ahead[0]) if len(ahead) else path.length


def _unicycle(
    path: Path, goal: float, q: np.ndarray, e: np.ndarray
) -> np.ndarray:
    """Maps a way through q to a base that cannot slip sideways, (n_u,).

    Args:
        path: The path.
        goal: Arc length at which the way ends.
        q: Where the robot is, shape (n_q,) [rad, m].
        e: The way there, shape (n_q,) [rad, m].
    """
    cosine, sine = math.cos(q[2]), math.sin(q[2])
    forward = cosine * e[0] + sine * e[1]
    aside = cosine * e[1] - sine * e[0]
    k = min(int(np.searchsorted(path.s, goal)), len(path.s) - 1) - 1
    turn = e[2]
    if k >= 0 and _drives(path)[k]:
        reach = max(math.hypot(e[0], e[1]), SHORTEST_PURSUIT)
        turn = 2.0 * forward * aside / reach**2
    return np.concatenate([[forward, turn], e[3:]])


def _deflected_velocity(
    v_WE: np.ndarray,
    error: PoseError,
    clearances: Clearances,
    leading: np.ndarray,
    guidance: Guidance,
    stopping: float,
    max_speed: float,
) -> np.ndarray:
    """Bends the servo's translational velocity to the guidance's side.

    An obstacle counts if it is near a leading sphere (w), ahead of it (a)
    and still in its way at the target (b): without b, the table top on which
    the target lies would count as something to go round. The direction then
    turns from straight ahead to along the obstacle, horizontally.

    Args:
        v_WE: Desired velocity of E in W, shape (3,) [m/s].
        error: The pose error from the end effector E to the target T.
        clearances: The oracle's distances and directions at the tick.
        leading: Whether each sphere moves with the hand, shape (n,) bool.
        guidance: How the tick is bent; its side matters here.
        stopping: Stopping distance d_s of this tick [m].
        max_speed: The servo's bound on |v_WE| [m/s].

    Returns:
        The bent velocity of E in W, shape (3,) [m/s].
    """
    speed = math.hypot(*v_WE)
    if guidance.side == 0.0 or speed == 0.0:
        return v_WE
    rows = np.flatnonzero(
        leading[clearances.sphere] & (clearances.distance < NEAR)
    )
    if not len(rows):
        return v_WE
    ahead_W = v_WE / speed
    d = clearances.distance[rows]
    away_W = -clearances.direction_W[rows]
    w = (NEAR - d) / (NEAR - stopping)
    a = (0.1 - away_W @ ahead_W) / 0.4
    b = -(d + away_W @ error.p_ET_W) / PASSED
    f = np.prod(np.minimum(np.maximum([w, a, b], 0.0), 1.0), axis=0)
    strength = float(f.max())
    if strength == 0.0:
        return v_WE
    mean_W = f**3 @ away_W
    norm = math.hypot(*mean_W)
    if norm == 0.0:
        return v_WE
    n_W = mean_W / norm
    along_W = guidance.side * np.array([n_W[1], -n_W[0], 0.0])  # n x z
    direction = (1.0 - strength) * ahead_W + strength * along_W
    length = math.hypot(*direction)
    if length < 1e-9:
        return v_WE
    return max(speed, 0.6 * strength * max_speed) * direction / length


def _tracked_directions(target: Target, along_W: np.ndarray) -> np.ndarray:
    """Returns the directions in which a target's twist is tracked.

    A target without a line and with equal weights is tracked in W's own; else
    there is a row for each direction that is not free, as long as the root of
    its weight. A line makes the rows longer that lead off it.

    Args:
        target: The target.
        along_W: Direction of its line, shape (3,); zero without one.

    Returns:
        Rows to multiply twists in W with, angular above translational, shape
        (r, 6).
    """
    if target.is_plain:
        return np.eye(6)
    R_TW = np.asarray(target.X_WT)[:3, :3].T
    rows = np.zeros((6, 6))
    rows[:3, :3] = rows[3:, 3:] = R_TW
    rows *= np.sqrt(target.weights)[:, None]
    if target.line is not None:
        stiff = np.eye(6) * np.sqrt(LINE_STIFFNESS)
        off = 1.0 - np.sqrt(LINE_STIFFNESS)
        stiff[3:, 3:] += off * np.outer(along_W, along_W)
        rows = rows @ stiff
    return rows[target.weights > 0.0]


def _stop_of(
    config: ing.JointLimitDamperConfig, robot: RobotModel, guidance: Guidance
) -> np.ndarray:
    """Returns the stopping distance of each arm joint, (n_arm,) [rad, m]."""
    hinge, slide = config.stop, config.slide_stop
    if guidance.joint_stop is not None:
        hinge = guidance.joint_stop
    if guidance.slide_stop is not None:
        slide = guidance.slide_stop
    return joint_margins(robot, math.radians(hinge), slide, STOP_SHARE)


def bodies_of(
    pairs: SelfCollisionPairs, near: NearPoints
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the bodies of the tree that points are on, (m,) each."""
    body = pairs.pairs.shapes.body
    first, second = pairs.pairs.first, pairs.pairs.second
    return body[first[near.pair]], body[second[near.pair]]


REFERENCE: dict[type, Callable] = {
    ing.ServoTracking: _servo_tracking,
    ing.VelocityCost: _velocity_cost,
    ing.VelocityLimits: _velocity_limits,
    ing.JointLimitDamper: _joint_limit_damper,
    ing.CollisionDamper: _collision_damper,
    ing.SelfCollisionDamper: _self_collision_damper,
    ing.ActiveCollisionCost: _active_collision_cost,
    ing.ManipulabilityCost: _manipulability_cost,
    ing.BaseOrientationCost: _base_orientation_cost,
    ing.PathTracking: _path_tracking,
    ing.MoverDamper: _mover_damper,
}
"""What adds the terms of each of the library's ingredients."""
