"""Follow the servo's twist, as far as the slack's price allows."""

import dataclasses as dc
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.guidance.deflection import (
    deflected_velocity,
    deflection,
)
from remosplat_drake.controller.ingredients.collision_damper import (
    CollisionDamperConfig,
)
from remosplat_drake.controller.kernels.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.kernels.tick_arrays import given_or
from remosplat_drake.controller.planning.kernels.path_places import (
    nearest_place,
)
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick
from remosplat_drake.controller.servo import servo_speed, servo_twist
from remosplat_drake.robot.robot_model import RobotModel

LAST_STRETCH = 0.1
"""What is left of a planned path when the servo takes part again, in radians
and metres alike: a base that cannot slip sideways ends beside the path."""


@dc.dataclass
class ServoTrackingConfig(Config):
    """How fast the end effector heads for its target."""

    # Proportional gain beta on the pose error [1/s].
    gain: Annotated[float, Interval(gt=0, le=100)] = 4.0
    # Bound on the end effector's translational speed [m/s].
    max_speed: Annotated[float, Interval(gt=0, le=2)] = 0.35
    # Bound on each entry of the slack delta; where the servo's twist is
    # faster, that is the bound, so that standing still stays feasible
    # [m/s, rad/s].
    slack_limit: Annotated[float, Interval(gt=0, le=1000)] = 10.0


class ServoTracking(CompiledIngredient):
    """Makes the end effector follow the servo's twist (paper eq. 2).

    The constraint is J_E u + delta = v_E with the cost |delta|^2 / (2 e) of
    the slack delta, as in the holistic controller of Haviland, Sünderhauf and
    Corke (2022). The tick's guidance bends the translational part of v_E. The
    price 1/e of the slack grows near the target, so that the end effector
    first gets there roughly and then exactly. Where guidance has a path, the
    servo leaves the way to that, but for its last stretch.

    Args:
        config: Gain and bounds of the servo.
        damper: The collision damper's distances, which the bend depends on.
    """

    term = "servo tracking"

    def __init__(
        self, config: ServoTrackingConfig, damper: CollisionDamperConfig
    ):
        self._config = config
        self._damper = damper

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Sets the twist that is tracked, and the slack's bounds and price.

        Args:
            program: The program of the tick.
            tick: What is known at the tick; the pose error, the clearances
                and the guidance matter here.
        """
        path = tick.guidance.path
        if path is not None and path.left(tick.state.q) > LAST_STRETCH:
            return
        config = self._config
        w, v = servo_twist(tick.error, config.gain, config.max_speed)
        v = deflected_velocity(
            v,
            tick.error,
            tick.clearances,
            tick.robot.leading_spheres,
            tick.guidance,
            self._damper.stopping_for(tick.guidance),
            config.max_speed,
        )
        V_WE = np.concatenate([w, v])
        state = tick.state
        # Standing still must stay feasible, however fast the servo's twist.
        program.track(
            self.term,
            J=np.concatenate([state.Jw_WE, state.Jv_WE]),
            V=V_WE,
            price=1.0 / tick.error_scale,
            limit=np.maximum(config.slack_limit, np.abs(V_WE)),
        )

    def settings(self, robot: RobotModel) -> "ServoSettings":
        """Makes what the kernel takes; see `CompiledIngredient`."""
        config = self._config
        return ServoSettings(
            config.gain,
            config.max_speed,
            config.slack_limit,
            self._damper.stopping,
        )


class ServoSettings(NamedTuple):
    """Settings of the ServoTracking, for kernels."""

    gain: float
    max_speed: float
    slack_limit: float
    stopping: float


@helper
def add_servo_tracking(own, k, tick, program):
    """Adds a `ServoTracking`; see `kernels/assemble.py`."""
    guidance, state = tick.guidance, tick.state
    if len(guidance.path_s):
        path_q, path_s = guidance.path_q, guidance.path_s
        s, apart = nearest_place(path_q, path_s, state.q)
        if path_s[-1] - s + apart > LAST_STRETCH:
            return
    gain = servo_speed(tick.p_ET_W, own.gain, own.max_speed)
    v = deflection(
        gain * tick.p_ET_W,
        tick.p_ET_W,
        (tick.sphere, tick.distance, tick.direction_W),
        tick.robot.leading,
        guidance.side,
        given_or(guidance.stopping, own.stopping),
        own.max_speed,
    )
    for r in range(3):
        program.V[r], program.V[3 + r] = gain * tick.rotation_W[r], v[r]
        for j in range(len(tick.u_previous)):
            program.J[r, j] = state.Jw_WE[r, j]
            program.J[3 + r, j] = state.Jv_WE[r, j]
    for r in range(6):
        program.limit[r] = max(own.slack_limit, abs(program.V[r]))
    program.price[0] = 1.0 / tick.error_scale
    program.count[1] = k + 1
