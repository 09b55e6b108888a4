"""Verify-then-scale: the guarantee of verification, and its proof.

The damper rows of the quadratic program are linear in u, and hold only in the
configuration at the start of the tick. So before a command is applied, its path
is checked: one tick of the command, and its braking ramp to a standstill. The
path ends where the station comes to rest if it receives no further command. The
supervisor uses the same ramp.

The guarantee. Let d_0 be a distance at the start of control: a sphere's
clearance from the scene, or the distance of two of the robot's convex shapes.
Let d_s be the smallest stopping distance that is used. Then

- at the end of every tick the distance is at least min(d_s, d_0),
- at all times it is at least min(d_s, d_0) - `TOLERANCE`, and
- no joint is ever beyond its limits or, if it started beyond them, farther
  beyond them than at the start,

if

- the scene does not move, and the map is correct (verification cannot detect
  obstacles that are missing in the map),
- the robot executes commands exactly, each until the next one arrives or the
  station brakes by itself (`robot/braking.py`), and
- the arithmetic is exact (its error is about 1e-14 m).

The first bound holds for ticks that are on time. A late tick may end between
two samples, where the distance may be smaller by `TOLERANCE`. The function
`between_samples.tolerated` prevents an accumulation of such decreases for a
robot that starts with at least d_s.

For a map that is not 1-Lipschitz, such as depth views, the guarantee is weaker:
the bounds hold for the distances that the map reports at the end of each tick,
and nothing is guaranteed in between.

Movers are included (`kernels/mover_sweep.py`). Under the conditions above, a
mover that keeps its bounds does not touch a moving sphere, unless the sphere
moves away from the mover. A sphere at rest may be touched. There is no
guarantee that perception detects a mover, or that it distinguishes the mover
from the robot's own parts. So no conformity to a standard is claimed. The
distance to keep has the same parts as the protective separation distance of
ISO/TS 15066: the motion of the mover and of the robot until the robot is at
rest, the uncertainties of both, and an additional distance.

Proof: when a command is applied, its path has passed a check with the distance
min(d_s, d_0) or more. The next tick either finds another command whose path
passes the check, or executes the first step of the ramp, which has already
passed. The possible positions of movers are predicted for the whole path, and
contain all later predictions. So the check of the rest of a ramp remains valid.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.kernels import kernel
from remosplat_drake.controller.verification.kernels.places import PathArrays
from remosplat_drake.controller.verification.kernels.stopping import (
    stopping_path,
)
from remosplat_drake.controller.verification.kernels.verified import (
    OBJECTIONS,
    Around,
    KeptArrays,
)
from remosplat_drake.controller.verification.kernels.verified import (
    path_objection as path_objection_of_kernels,
)
from remosplat_drake.controller.verification.map_calls import (
    MapCalls,
    map_for_kernels,
)
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.robot.braking import spare_time
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.robot_state import RobotState
from remosplat_drake.scene.mover import STILL
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.motion import prompt_motion


@dc.dataclass(frozen=True, eq=False)
class Surroundings:
    """The known state of robot and map at the start of a path.

    Attributes:
        robot: The robot, whose kinematics predict configurations.
        field: The map.
        state: Kinematics at the configuration.
        clearance: Clearance of each sphere, or a lower bound that is at least
            d_s, shape (n,) [m].
        stopping: Stopping distance d_s that spheres keep from the scene [m].
        dt: Control period [s].
        self_clearance: Pairs of the robot's own shapes and their stopping
            distance; None if self-collision is not checked.
    """

    robot: RobotModel
    field: DistanceField
    state: RobotState
    clearance: np.ndarray
    stopping: float
    dt: float
    self_clearance: SelfClearance | None = None

    def path(self, u: np.ndarray) -> PathArrays:
        """Makes the path of a command and its ramp (robot without delay).

        Args:
            u: The command, shape (n_u,) [rad/s, m/s].
        """
        return stopping_path(
            self.robot.arrays,
            prompt_motion(self.robot.n_u),
            np.array(self.state.q, float),
            # The array is copied, since kernels are compiled for writable
            # arrays.
            np.array(u, float),
            float(self.dt),
            spare_time(self.dt),
        )

    def objection(self, path: PathArrays) -> str:
        """Returns the reason to reject a path.

        Args:
            path: The path.

        Returns:
            `JOINT_LIMIT`, `SELF_COLLISION` or `COLLISION`; empty if the path is
            allowed.
        """
        own = self.self_clearance
        with MapCalls(self.robot, self.field) as line:
            number = _path_objection(
                float(self.dt),
                own is not None,
                (own or SelfClearance.make(self.robot, 0.0)).arrays,
                0.0 if own is None else float(own.stopping),
                self.robot.arrays,
                *map_for_kernels(self.field),
                line,
                STILL.arrays,
                prompt_motion(self.robot.n_u),
                np.array(self.state.spheres.p_WS, float),
                np.array(self.clearance, float),
                float(self.stopping),
                path,
            )
        return OBJECTIONS[number]


@kernel
def _path_objection(
    dt,
    checks_self_collision,
    own,
    self_stopping,
    robot,
    compiled,
    off,
    line,
    movers,
    motion,
    p_WS,
    clearance,
    stopping,
    path,
):
    """Calls the kernel `path_objection` from Python."""
    kept = KeptArrays(dt, 0.0, checks_self_collision, own, self_stopping, 0.0)
    around = Around(
        robot,
        (compiled, off, line),
        movers,
        motion,
        path.starts[0],
        p_WS,
        clearance,
        stopping,
    )
    return path_objection_of_kernels(kept, around, path)
