"""Runs a user's controller, a function from q to u, in the benchmark.

The user's module contains a function that makes a controller:

    def make(robot, field, X_WT, dt):
        def control(q, u_previous):
            ...
            return u
        return control

`robot` is a `RobotModel` (kinematics, limits, spheres), `field` the map as a
`DistanceField`, `X_WT` the target pose (4, 4) and `dt` the control period [s];
q is a configuration (n_q,) and u the command (n_u,) for the next dt. On the
command line, the controller's name is MODULE:FUNCTION. Oracle, control period
and time limit are those of the shipped method `sdf-hard`, or of METHOD if the
name is MODULE:FUNCTION:METHOD.
"""

import hashlib
import importlib
import inspect
from collections.abc import Callable
from time import perf_counter

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.robot.pose_error import PoseError, pose_error
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.tick_report import OPTIMAL

Control = Callable[[np.ndarray, np.ndarray], np.ndarray]
MakeControl = Callable[[RobotModel, DistanceField, np.ndarray, float], Control]

LIMIT_TOLERANCE = 1e-6
"""Fraction of the velocity limits by which a command may exceed them, because
of rounding errors."""


def load_controller(name: str) -> MakeControl:
    """Imports the function that MODULE:FUNCTION names.

    Args:
        name: The module and its function, as MODULE:FUNCTION.

    Returns:
        The function that makes a controller for one trial.

    Raises:
        RemoSplatError: The module or the function does not exist.
    """
    module, _, function = name.partition(":")
    try:
        return getattr(importlib.import_module(module), function)
    except ImportError as error:
        raise RemoSplatError(f"--methods: {name}: {error}") from error
    except AttributeError:
        raise RemoSplatError(
            f"--methods: {name}: the module has no {function!r}"
        ) from None


def source_digest(name: str) -> str:
    """Returns a digest of the source of a controller's module."""
    module = inspect.getmodule(load_controller(name))
    assert module is not None
    return hashlib.sha256(inspect.getsource(module).encode()).hexdigest()[:16]


def drive(
    control: Control,
    robot: RobotModel,
    q0: np.ndarray,
    X_WT: np.ndarray,
    *,
    dt: float,
    ticks: int,
    until: Callable[[PoseError], bool],
) -> Trajectory:
    """Runs the closed loop with an ideal robot, like the kinematic station's.

    Args:
        control: The controller, a function from (q, u_previous) to u.
        robot: Model of the robot that the controller drives.
        q0: Configuration at the start, shape (n_q,).
        X_WT: Target pose of the end effector in W, shape (4, 4).
        dt: Control period [s].
        ticks: The run ends after this many control ticks at the latest.
        until: Function that is called with the pose error before every tick;
            the run ends when it returns True.

    Returns:
        The trajectory of the run.

    Raises:
        RemoSplatError: A command is not finite, too fast or of another shape.
    """
    q, u, seconds = [q0], [np.zeros(robot.n_u)], []
    for tick in range(ticks):
        if until(pose_error(robot.end_effector_pose(q[-1]), X_WT)):
            break
        start = perf_counter()
        command = np.array(control(q[-1].copy(), u[-1].copy()), float)
        seconds.append(perf_counter() - start)
        _check_command(command, robot, tick)
        u.append(command)
        q.append(robot.advance(q[-1], command, dt))
    n = len(seconds)
    return Trajectory(
        time=dt * np.arange(n),
        q=np.array(q),
        u=np.array(u[1:]).reshape(n, robot.n_u),
        status=np.full(n, OPTIMAL),
        scale=np.ones(n),
        clearance=np.full(n, np.inf),
        timings={"total": np.array(seconds)},
    )


def _check_command(u: np.ndarray, robot: RobotModel, tick: int) -> None:
    if u.shape != (robot.n_u,) or not np.isfinite(u).all():
        raise RemoSplatError(
            f"tick {tick}: a command must be {robot.n_u} finite numbers,"
            f" got {u}"
        )
    excess = np.abs(u) / robot.velocity_limit
    if excess.max() > 1.0 + LIMIT_TOLERANCE:
        raise RemoSplatError(
            f"tick {tick}: entry {int(excess.argmax())} of the command is "
            f"{excess.max():.2f} times the robot's limit"
        )
