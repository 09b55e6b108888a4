"""Follow a planned path: a quadratic price on leaving it."""

import dataclasses as dc
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.planning.path import Path
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick


@dc.dataclass
class PathTrackingConfig(Config):
    """How a planned path is followed."""

    # Weight of the squared deviation from the velocity along the path.
    weight: Annotated[float, Interval(gt=0, le=1000)] = 1.0
    # How far ahead on the path the robot aims, in radians and metres alike.
    look_ahead: Annotated[float, Interval(gt=0, le=2)] = 0.2
    # Proportional gain on what is left of the path [1/s].
    gain: Annotated[float, Interval(gt=0, le=100)] = 4.0
    # Bound on the speed of all of the robot's spheres [m/s].
    max_speed: Annotated[float, Interval(gt=0, le=2)] = 0.35


class PathTracking:
    """Makes the robot follow the path of the tick's guidance, if it has one.

    The cost is weight/2 |u - u_path|^2, where u_path leads to a point of the
    path a little ahead of the nearest one (pure pursuit; Coulter 1992). All
    rows of the program stay: what is in the way is kept off as ever.

    Args:
        config: Weight, speed and how far ahead the robot aims.
    """

    def __init__(self, config: PathTrackingConfig):
        self._config = config

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds the cost of leaving the path.

        Args:
            program: The program of the tick.
            tick: What is known at the tick; the configuration and the
                guidance's path matter here.
        """
        path = tick.guidance.path
        if path is None:
            return
        u = path_velocity(path, tick, self._config)
        weights = np.full(program.n_u, self._config.weight)
        program.add_quadratic_cost("path", weights)
        program.add_linear_cost("path", -weights * u)


def path_velocity(
    path: Path, tick: Tick, config: PathTrackingConfig
) -> np.ndarray:
    """Computes the command that leads along a path, shape (n_u,).

    Args:
        path: The path.
        tick: What is known at the tick; configuration and limits matter.
        config: Speed and how far ahead the robot aims.
    """
    robot, q = tick.robot, tick.state.q
    s, apart = path.nearest(q)
    e = path.at(s + config.look_ahead) - q
    size = float(np.linalg.norm(e))
    if size < 1e-9:
        return np.zeros(robot.n_u)
    along = e / size
    speed = config.gain * (path.length - s + apart)
    fastest = np.linalg.norm(tick.state.Jv_WS @ along, axis=1).max(initial=0.0)
    limits = robot.velocity_limit / np.maximum(np.abs(along), 1e-9)
    speed = min(speed, config.max_speed / max(fastest, 1e-9), limits.min())
    return speed * along
