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


class ServoTracking:
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
            "servo tracking",
            J=np.concatenate([state.Jw_WE, state.Jv_WE]),
            V=V_WE,
            price=1.0 / tick.error_scale,
            limit=np.maximum(config.slack_limit, np.abs(V_WE)),
        )
