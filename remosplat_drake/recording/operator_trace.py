"""`OperatorTrace`: computes the curves of the paper's figure 5 from a log."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np

from remosplat_drake.controller.deviation import (
    deviation,
    end_effector_velocities,
)
from remosplat_drake.recording.run_log import RunLog
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField


@dc.dataclass(frozen=True, eq=False)
class OperatorTrace:
    """The curves of the paper's figure 5, over T ticks.

    Attributes:
        time: Times of the ticks, shape (T,) [s].
        clearance: Smallest distance to the map that was in use at the tick,
            shape (T,) [m]; inf beyond the influence distance.
        deviation: |v desired - v executed| of the end effector, shape (T,)
            [m/s].
        true_clearance: Smallest distance to the true scene, shape (T,) [m];
            None if the true scene is unknown.
    """

    time: np.ndarray
    clearance: np.ndarray
    deviation: np.ndarray
    true_clearance: np.ndarray | None = None


def trace_operator(
    log: RunLog,
    robot: RobotModel,
    *,
    gain: float,
    max_speed: float,
    truth: Callable[[float], DistanceField] | None = None,
    on_tick: Callable[[int], None] | None = None,
) -> OperatorTrace:
    """Computes the curves of figure 5 from a log.

    Args:
        log: The log of a run.
        robot: The robot of the run.
        gain: Gain of the controller's servo [1/s].
        max_speed: Largest desired speed of the servo [m/s].
        truth: Function that returns the true scene at a time [s]; None if the
            true scene is unknown.
        on_tick: Function that is called with the number of processed ticks.
    """
    count = len(log)
    deviations, true_clearance = np.zeros(count), np.zeros(count)
    for k, row in enumerate(log.rows):
        deviations[k] = deviation(
            *end_effector_velocities(
                log.report(k), row["u_executed"], robot, gain, max_speed
            )
        )
        if truth is not None:
            field = truth(float(row["time"]))
            spheres = robot.spheres_at(row["q"])
            true_clearance[k] = field.clearances(spheres).minimum()
        if on_tick is not None:
            on_tick(k + 1)
    return OperatorTrace(
        log.rows["time"],
        log.rows["clearance"],
        deviations,
        None if truth is None else true_clearance,
    )
