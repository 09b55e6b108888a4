"""Follow the servo's twist, as far as the slack's price allows."""

import dataclasses as dc
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.guidance.deflection import deflected_velocity
from remosplat_drake.controller.ingredients.collision_damper import (
    CollisionDamperConfig,
)
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick
from remosplat_drake.controller.servo import servo_twist


@dc.dataclass
class ServoTrackingConfig(Config):
    """How fast the end effector goes for its target."""

    # Proportional gain beta on the pose error [1/s].
    gain: Annotated[float, Interval(gt=0, le=100)] = 4.0
    # Bound on the translational speed [m/s].
    max_speed: Annotated[float, Interval(gt=0, le=2)] = 0.35
    # Bound on each entry of the slack, or the servo's twist where that is
    # faster [m/s, rad/s].
    slack_limit: Annotated[float, Interval(gt=0, le=1000)] = 10.0


class ServoTracking:
    """J_E u + delta = v_E with the cost |delta|^2 / (2 e) (paper eq. 2).

    The translational part of v_E is bent by the tick's guidance.

    The price 1/e of the slack grows near the target, so that the end
    effector first gets there roughly and then exactly.
    """

    def __init__(
        self, config: ServoTrackingConfig, damper: CollisionDamperConfig
    ):
        self._config = config
        self._damper = damper

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Sets what is tracked, and the slack's bounds and price."""
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
            "servo tracking",
            J=np.concatenate([state.Jw_WE, state.Jv_WE]),
            V=V_WE,
            price=1.0 / tick.error_scale,
            limit=np.maximum(config.slack_limit, np.abs(V_WE)),
        )
