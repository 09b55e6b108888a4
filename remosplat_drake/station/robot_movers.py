"""`RobotMovers`: represents a robot as movers for another robot."""

import dataclasses as dc

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Mover, Movers

_STEP = 1e-4
"""Time step for the finite differences of the links' poses [s]."""

MOST_ACCELERATION = 15.0
"""Bound of the commanded acceleration of any point of a robot [m/s^2].

When a simulated Panda braked with its arm stretched out, its acceleration
reached 13 m/s^2. The sum of the limits of all joints is 200 m/s^2. This bound
would be so large that no robot could approach another one."""

_JUMP = 5e-3
"""A link deviates by at most this length from a motion within its acceleration
bound [m]. Deviations occur because commands change in steps from tick to
tick."""


@dc.dataclass(frozen=True, eq=False)
class LinkShape:
    """A rounded box that encloses all spheres of a link.

    Attributes:
        link: Name of the link.
        body: Number of the link's body in the robot's kinematic tree.
        X_LM: Pose of the box in the link's frame, shape (4, 4).
        half_extents: Half edges of the inner box, shape (3,) [m].
        radius: Distance by which the rounded box extends beyond the inner box
            [m].
    """

    link: str
    body: int
    X_LM: np.ndarray
    half_extents: np.ndarray
    radius: float


def link_shapes(robot: RobotModel) -> list[LinkShape]:
    """Makes a rounded box for each link that encloses the link's spheres.

    The inner box is the bounding box of the spheres' centres along their
    principal axes. The radius is that of the largest sphere.

    Args:
        robot: The robot.
    """
    shapes = []
    for link in dict.fromkeys(robot.spheres.links):
        spheres = robot.spheres.on_link(link)
        p_LS = np.asarray(spheres.p_LS, float)
        middle = p_LS.mean(axis=0)
        _, _, axes = np.linalg.svd(p_LS - middle, full_matrices=True)
        R_LM = axes.T * np.array([1.0, 1.0, np.sign(np.linalg.det(axes))])
        p_M = (p_LS - middle) @ R_LM
        low, high = p_M.min(axis=0), p_M.max(axis=0)
        X_LM = np.eye(4)
        X_LM[:3, :3] = R_LM
        X_LM[:3, 3] = middle + R_LM @ (0.5 * (low + high))
        shapes.append(
            LinkShape(
                link,
                robot.tree.index(link),
                X_LM,
                0.5 * (high - low),
                float(np.max(spheres.radius)),
            )
        )
    return shapes


def link_movers(
    robot: RobotModel,
    shapes: list[LinkShape],
    q: np.ndarray,
    u: np.ndarray,
    *,
    name: str,
    max_speed: float,
    max_acceleration: float,
) -> list[Mover]:
    """Returns the links of a robot as movers.

    Args:
        robot: The robot.
        shapes: The shapes of the robot's links.
        q: Configuration of the robot, shape (n_q,).
        u: Commanded velocities of the robot, shape (n_u,) [m/s, rad/s].
        name: Display name of the robot.
        max_speed: Speed that no point of a link exceeds [m/s].
        max_acceleration: Acceleration that no point of a link exceeds [m/s^2].
    """
    before, now, after = (
        robot.body_poses(robot.advance(q, u, step) if step else q)
        for step in (-_STEP, 0.0, _STEP)
    )
    movers = []
    for shape in shapes:
        X_WM = now[shape.body] @ shape.X_LM
        back, ahead = (X[shape.body] @ shape.X_LM for X in (before, after))
        turn = (ahead[:3, :3] - back[:3, :3]) @ X_WM[:3, :3].T / (2 * _STEP)
        movers.append(
            Mover(
                f"{name}'s {shape.link}",
                RigidTransform(
                    RotationMatrix.ProjectToRotationMatrix(X_WM[:3, :3]),
                    X_WM[:3, 3],
                ),
                shape.half_extents,
                shape.radius,
                (ahead[:3, 3] - back[:3, 3]) / (2 * _STEP),
                np.array([turn[2, 1], turn[0, 2], turn[1, 0]]),
                max_speed,
                max_acceleration,
                position_error=_JUMP,
            )
        )
    return movers


class RobotMovers(LeafSystem):
    """Outputs a robot's links as movers, for another robot.

    .. pydrake_system::

        name: RobotMovers
        input_ports:
        - configuration
        - velocity
        output_ports:
        - movers

    The input `configuration` is the robot's q, and `velocity` the command u
    that the robot executes. The output `movers` are the robot's links as
    `Movers`.

    Args:
        robot: The robot.
        name: Display name of the robot.
        max_speed: Speed that no point of a link exceeds [m/s].
        max_acceleration: Acceleration that no point of a link exceeds [m/s^2].
    """

    def __init__(
        self,
        *,
        robot: RobotModel,
        name: str,
        max_speed: float,
        max_acceleration: float,
    ):
        super().__init__()
        self._robot, self._shapes = robot, link_shapes(robot)
        self._told = {
            "name": name,
            "max_speed": max_speed,
            "max_acceleration": max_acceleration,
        }
        self._configuration = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._velocity = self.DeclareVectorInputPort("velocity", robot.n_u)
        self.DeclareAbstractOutputPort(
            "movers", lambda: Value[object](Movers(0.0)), self._calc_movers
        )

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        configuration: OutputPort,
        velocity: OutputPort,
        **arguments,
    ) -> OutputPort:
        """Adds the system to a diagram, and returns its movers.

        Args:
            builder: The builder of the diagram.
            configuration: The output port of the robot's q.
            velocity: The output port of the command that the robot executes.
            **arguments: The arguments of `RobotMovers`.
        """
        system = builder.AddSystem(RobotMovers(**arguments))
        builder.Connect(configuration, system.GetInputPort("configuration"))
        builder.Connect(velocity, system.GetInputPort("velocity"))
        return system.GetOutputPort("movers")

    def _calc_movers(self, context: Context, output: AbstractValue):
        movers = link_movers(
            self._robot,
            self._shapes,
            np.array(self._configuration.Eval(context)),
            np.array(self._velocity.Eval(context)),
            **self._told,
        )
        output.set_value(Movers(context.get_time(), movers))
