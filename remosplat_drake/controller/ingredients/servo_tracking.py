"""Servo tracking: the end effector tracks the servo's twist, with slack."""

import dataclasses as dc
import math
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import NOTHING
from remosplat_drake.base.ranges import Config
from remosplat_drake.base.vectors import dot
from remosplat_drake.controller.ingredients.collision_damper import (
    CollisionDamperConfig,
)
from remosplat_drake.controller.ingredients.deflection import (
    deflection,
)
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.kernels.path_places import (
    nearest_place,
)
from remosplat_drake.controller.program.kernels.tick_arrays import given_or
from remosplat_drake.controller.program.servo import (
    LINE_STIFFNESS,
    line_twist,
    servo_gains,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.target_arrays import place_on_line, target_of

LAST_STRETCH, LAST_DRIVE = 0.01, 0.1
"""Remaining length of a planned path below which the servo is active again; a
radian counts like a metre. `LAST_STRETCH` is small, since the servo is slower
than path tracking. `LAST_DRIVE` is for differential bases, which approach the
end of a path slowly.

The length is measured along the path, from the point nearest to the robot. The
distance of the robot from the path is not included: a differential base ends
beside its path and cannot move sideways, so the arm must leave the path to
reach the target."""

SERVO_SPEED = 1.0
"""Bound of the servo's speed if the configuration contains none [m/s]."""


@dc.dataclass
class ServoTrackingConfig(Config):
    """Gain and speed bounds of the servo."""

    # Proportional gain beta of the pose error [1/s].
    gain: Annotated[float, Interval(gt=0, le=100)] = 4.0
    # Bound of the end effector's translational speed [m/s]. If it is absent, it
    # is 1 m/s, or 0.35 m/s on a real robot.
    max_speed: Annotated[float, Interval(gt=0, le=10)] | None = None
    # Bound of each entry of the slack delta [m/s, rad/s]. If the magnitude of
    # the servo's twist is larger, this magnitude is the bound, so that a
    # command of zero is feasible.
    slack_limit: Annotated[float, Interval(gt=0, le=1000)] = 10.0

    @property
    def fastest(self) -> float:
        """Bound of the end effector's translational speed [m/s]."""
        return SERVO_SPEED if self.max_speed is None else self.max_speed


class ServoTracking(CompiledIngredient):
    """Tracks the servo's twists by the end effectors (paper eq. 2).

    `add_servo_tracking` adds the constraint and its cost.

    Args:
        config: Gain and speed bounds of the servo.
        damper: Settings of the collision damper, whose distances the deflection
            uses.
    """

    term = "servo tracking"

    def __init__(
        self, config: ServoTrackingConfig, damper: CollisionDamperConfig
    ):
        self._config = config
        self._damper = damper

    def settings(self, robot: RobotModel) -> "ServoSettings":
        """Makes the input of the kernel; see `CompiledIngredient`."""
        config = self._config
        return ServoSettings(
            config.gain,
            config.fastest,
            config.slack_limit,
            self._damper.stopping,
        )


class ServoSettings(NamedTuple):
    """Settings of a `ServoTracking` for kernels."""

    gain: float
    max_speed: float
    slack_limit: float
    stopping: float


@kernel(returns=NOTHING)
def add_servo_tracking(own, k, tick, program):
    """Tracks the servo's twist with each end effector that has a target.

    The constraint on the command u and the slack delta, and their cost, are

        J_E u + delta = V_WE,    |delta|^2 / (2 e),
        |delta| <= max(slack_limit, |V_WE|)

    (paper eq. 2; holistic controller of Haviland, Sünderhauf and Corke 2022).
    J_E is the Jacobian of the end effector in W, and V_WE the desired twist in
    W, angular before translational [rad/s, m/s]. e is the error to the target
    [m]; see `servo.error_scale`. The weight 1/e increases near the target, so
    the end effector tracks the twist roughly at first, and exactly at the end.
    The bounds of the slack hold for each entry. With them, u = 0 is feasible.

    A free direction of the target has no row; all other directions have the
    target's weights. Guidance deflects the translational part of V_WE, unless
    the target has a straight line. If guidance has a path, tracking begins when
    the part of the path after the nearest point is at most `LAST_STRETCH` long,
    or `LAST_DRIVE` for a differential base. No twist is tracked if the aim
    contains a configuration, since the poses of the targets are not sufficient
    to reach it.

    See `CompiledIngredient` for the arguments.
    """
    guidance, state = tick.guidance, tick.state
    if tick.aim.by_path:
        return
    if len(guidance.path_s):
        path_q, path_s = guidance.path_q, guidance.path_s
        s, _ = nearest_place(path_q, path_s, state.q)
        last = LAST_DRIVE if tick.robot.n_base == 2 else LAST_STRETCH
        if path_s[-1] - s > last:
            return
    row = 0
    for i in range(len(tick.aim.effector)):
        effector = tick.aim.effector[i]
        first, row = row, _track_target(own, tick, program, i, row)
        for r in range(first, row):
            program.limit[r] = max(own.slack_limit, abs(program.V[r]))
            program.price[r] = 1.0 / tick.error_scales[i]
        program.tracked[effector:] = row
    program.count[1], program.count[3] = k + 1, row


@helper
def _track_target(own, tick, program, i, row):
    """Writes a target's rows from a given row on; returns the next row."""
    target, effector = target_of(tick.aim, i), tick.aim.effector[i]
    guidance, X_WE = tick.guidance, tick.state.X_WE[effector]
    Jw, Jv = tick.state.Jw_WE[effector], tick.state.Jv_WE[effector]
    along_W = np.zeros(3)
    if target.speed > 0.0:
        w, v = line_twist(X_WE, target, own.gain, own.max_speed)
        along_W = place_on_line(X_WE, target)[0]
    else:
        p_ET_W = tick.p_ET_W[i]
        turning, going = servo_gains(
            p_ET_W, own.gain, own.max_speed, target.onward
        )
        w = turning * tick.rotation_W[i]
        v = deflection(
            going * p_ET_W,
            p_ET_W,
            (tick.sphere, tick.distance, tick.direction_W),
            tick.robot.leading[effector],
            guidance.side,
            given_or(guidance.stopping, own.stopping),
            own.max_speed,
        )
        if _all_alike(target.weights):
            return _track(Jw, Jv, w, v, program, row)
    return _track_directions(target, Jw, Jv, w, v, along_W, program, row)


@helper
def _all_alike(weights):
    most = 0.0
    for weight in weights:
        most = max(most, abs(weight - 1.0))
    return most == 0.0


@helper
def _track(Jw, Jv, w, v, program, row):
    """Tracks a twist in all directions of W."""
    for r in range(3):
        program.V[row + r], program.V[row + 3 + r] = w[r], v[r]
        for j in range(program.J.shape[1]):
            program.J[row + r, j] = Jw[r, j]
            program.J[row + 3 + r, j] = Jv[r, j]
    return row + 6


@helper
def _track_directions(target, Jw, Jv, w, v, along_W, program, row):
    """Tracks a twist in the constrained directions of a target.

    Each rotation or translation of T that is not free has a row, scaled by the
    square root of its weight. On a line, the rows perpendicular to the line are
    multiplied by a factor.
    """
    stiff = math.sqrt(LINE_STIFFNESS) if target.speed > 0.0 else 1.0
    direction = np.empty(3)
    for i in range(6):
        if target.weights[i] == 0.0:
            continue
        root = math.sqrt(target.weights[i])
        along = 0.0
        for c in range(3):
            direction[c] = root * target.X_WT[c, i % 3]
            along += direction[c] * along_W[c]
        for c in range(3):
            direction[c] *= stiff
            if i >= 3:
                direction[c] += (1.0 - stiff) * along * along_W[c]
        J, twist = (Jw, w) if i < 3 else (Jv, v)
        program.V[row] = dot(direction, twist)
        for j in range(J.shape[1]):
            program.J[row, j] = dot(direction, J[:, j])
        row += 1
    return row
