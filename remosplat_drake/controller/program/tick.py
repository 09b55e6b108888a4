"""`Tick`: the state of one control tick."""

import dataclasses as dc
from functools import cached_property

import numpy as np

from remosplat_drake.controller.program.guidance import DIRECT, Guidance
from remosplat_drake.controller.program.servo import error_scale
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.robot_state import RobotState
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.near_movers import NearMovers
from remosplat_drake.signals.target import Target


@dc.dataclass(frozen=True, eq=False)
class Tick:
    """The state of one control tick.

    Attributes:
        robot: The robot, with its limits and kinematics.
        state: Kinematics at the measured configuration q.
        aim: The targets of the end effectors.
        clearances: The distances of the robot's spheres from the map; distances
            beyond the influence distance are omitted.
        u_previous: The command that is being executed, shape (n_u,).
        dt: Control period [s].
        guidance: The guidance selected by `GuidanceSelector`.
        sphere_tube: Bound of each sphere's deviation from its predicted path,
            at the speeds of the present command, shape (n,) [m]; None for a
            robot without delay.
        movers: The movers; None if none are known.
        time: The time of the tick [s].

    Example:
        >>> import remosplat_drake as rs
        >>> class FaceTarget:
        ...     def AddToProgram(self, program, tick):
        ...         if tick.error.distance < 0.1:
        ...             program.add_linear_cost("wait", program.upper * 0)
    """

    robot: RobotModel
    state: RobotState
    aim: Aim
    clearances: Clearances
    u_previous: np.ndarray
    dt: float
    guidance: Guidance = DIRECT
    sphere_tube: np.ndarray | None = None
    movers: Movers | None = None
    time: float = 0.0

    def near_movers(
        self, within: float, ahead: float = 0.0, by: float = 0.0
    ) -> NearMovers:
        """Finds movers near the robot's present configuration.

        Args:
            within: Pairs of a sphere and a mover at or beyond this distance are
                omitted [m].
            ahead: Movers are placed where they are after this time if their
                twists are constant [s].
            by: Further time [s]. Distances are reduced by the greatest possible
                deviation of movers from their prediction after this time.
        """
        if self.movers is None:
            return NearMovers.none()
        movers = self.movers.moved_on(ahead, ahead) if ahead else self.movers
        spheres = self.state.spheres
        return NearMovers.find(movers, self.time, spheres, within, by)

    @property
    def target(self) -> Target:
        """The first target."""
        return self.aim.first

    @property
    def X_WT(self) -> np.ndarray:
        """Pose of the target T in the world W, shape (4, 4)."""
        return self.target.X_WT

    @cached_property
    def errors(self) -> tuple[PoseError, ...]:
        """The pose error to each target, in its constrained directions."""
        return self.aim.errors(self.state.X_WEs)

    @property
    def error(self) -> PoseError:
        """The pose error to the first target."""
        return self.errors[0]

    @property
    def error_scales(self) -> list[float]:
        """The paper's error e of each target [m]; see `servo.error_scale`."""
        items = zip(self.errors, self.aim.items, strict=True)
        return [error_scale(e.p_ET_E, t.arrays) for e, (_, t) in items]

    @property
    def error_scale(self) -> float:
        """The paper's error e: L1 distance to the target, at least 1e-3 [m].

        If there are several targets, it is the largest of their errors. Costs
        are divided by e, and its lower bound keeps them finite at the target.
        """
        return max(self.error_scales)

    @cached_property
    def approach_rates(self) -> np.ndarray:
        """The rows J_d = n' Jv_WS of all m clearances, shape (m, n_u).

        J_d u is the rate at which a clearance decreases [m/s] (paper eq. 16).
        """
        clearances = self.clearances
        return np.einsum(
            "mi,mij->mj",
            clearances.direction_W,
            self.state.Jv_WS[clearances.sphere],
        )
