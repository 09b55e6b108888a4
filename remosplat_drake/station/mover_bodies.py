"""Adds bodies that follow the motions of movers to a dynamic station.

A body is heavy, and a strong force pulls it to the pose of its mover. So it
pushes a robot that it touches, but the robot hardly deflects the body.
"""

import math
from collections.abc import Sequence

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.geometry import (
    CollisionFilterDeclaration,
    GeometrySet,
    SceneGraph,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialForce, SpatialVelocity
from pydrake.multibody.plant import (
    CoulombFriction,
    ExternallyAppliedSpatialForce,
    MultibodyPlant,
)
from pydrake.multibody.tree import RigidBody, SpatialInertia
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem

from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.mover_shape import shape_of
from remosplat_drake.signals import station_ports as ports

MOVERS = "movers"
"""Name of the model instance with the bodies of all movers."""

MASS = 1000.0
"""Mass of a body [kg]."""

TURNING_RADIUS = 0.3
"""Radius of gyration of a body [m]."""

RATE = 200.0
"""Natural frequency of a body's critically damped return to its mover
[rad/s]."""

COLOUR = np.array([0.93, 0.45, 0.13, 1.0])

_FRICTION = CoulombFriction(0.6, 0.6)


def add_mover_bodies(
    plant: MultibodyPlant, movers: Sequence[Mover]
) -> list[RigidBody]:
    """Adds a body for each mover, at its initial pose.

    Args:
        plant: A plant with a scene graph, before `Finalize`.
        movers: The movers at the start.
    """
    if not movers:
        return []
    instance = plant.AddModelInstance(MOVERS)
    bodies = []
    for i, mover in enumerate(movers):
        inertia = SpatialInertia.SolidSphereWithMass(
            MASS, TURNING_RADIUS / math.sqrt(0.4)
        )
        body = plant.AddRigidBody(f"{i}: {mover.name}", instance, inertia)
        shape, name = shape_of(mover), f"mover_{i}"
        plant.RegisterVisualGeometry(
            body, RigidTransform(), shape, name, COLOUR
        )
        plant.RegisterCollisionGeometry(
            body, RigidTransform(), shape, name, _FRICTION
        )
        plant.SetDefaultFloatingBaseBodyPose(body, mover.X_WM)
        bodies.append(body)
    plant.set_gravity_enabled(instance, False)
    return bodies


def let_pass(
    plant: MultibodyPlant, scene_graph: SceneGraph, bodies: Sequence[RigidBody]
) -> None:
    """Excludes contact between movers, and between movers and static geometry.

    Args:
        plant: The finalized plant.
        scene_graph: The scene graph with its geometry.
        bodies: The movers' bodies.
    """
    if not bodies:
        return

    def shapes(*of: RigidBody) -> GeometrySet:
        return GeometrySet(
            [g for b in of for g in plant.GetCollisionGeometriesForBody(b)]
        )

    scene_graph.collision_filter_manager().Apply(
        CollisionFilterDeclaration()
        .ExcludeWithin(shapes(*bodies))
        .ExcludeBetween(shapes(*bodies), shapes(plant.world_body()))
    )


class MoverDriver(LeafSystem):
    """Computes the forces that pull bodies to the poses of their movers.

    .. pydrake_system::

        name: MoverDriver
        input_ports:
        - movers
        - body_poses
        - body_spatial_velocities
        output_ports:
        - spatial_forces

    The input `movers` are the `Movers`, one for each body and in the same
    order. The other ports are connected to the plant's ports of the same names.

    Args:
        bodies: The bodies.
    """

    def __init__(self, *, bodies: Sequence[RigidBody]):
        super().__init__()
        self._bodies = [body.index() for body in bodies]
        self._movers = self.DeclareAbstractInputPort(
            ports.MOVERS, Value[object]()
        )
        self._poses = self.DeclareAbstractInputPort(
            "body_poses", AbstractValue.Make([RigidTransform()])
        )
        self._velocities = self.DeclareAbstractInputPort(
            "body_spatial_velocities", AbstractValue.Make([SpatialVelocity()])
        )
        self.DeclareAbstractOutputPort(
            "spatial_forces",
            lambda: AbstractValue.Make([ExternallyAppliedSpatialForce()]),
            self._calc_forces,
        )

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        plant: MultibodyPlant,
        bodies: Sequence[RigidBody],
    ) -> None:
        """Adds the driver to a station, and exports its input `movers`.

        Args:
            builder: The builder of the station.
            plant: The finalized plant.
            bodies: The movers' bodies.
        """
        driver = builder.AddNamedSystem(
            "mover_driver", MoverDriver(bodies=bodies)
        )
        for port, name in (
            (plant.get_body_poses_output_port(), "body_poses"),
            (
                plant.get_body_spatial_velocities_output_port(),
                "body_spatial_velocities",
            ),
        ):
            builder.Connect(port, driver.GetInputPort(name))
        builder.Connect(
            driver.get_output_port(),
            plant.get_applied_spatial_force_input_port(),
        )
        builder.ExportInput(driver.GetInputPort(ports.MOVERS), ports.MOVERS)

    def _calc_forces(self, context: Context, output: AbstractValue):
        movers: Movers = self._movers.Eval(context)
        poses = self._poses.Eval(context)
        velocities = self._velocities.Eval(context)
        forces = []
        for body, mover in zip(self._bodies, movers, strict=True):
            force = ExternallyAppliedSpatialForce()
            force.body_index = body
            force.p_BoBq_B = np.zeros(3)
            force.F_Bq_W = pull(mover, poses[body], velocities[body])
            forces.append(force)
        output.set_value(forces)


def pull(mover: Mover, X_WB: RigidTransform, V_WB: SpatialVelocity):
    """Returns the force that pulls a body to the pose of its mover.

    Args:
        mover: The mover, which has the desired pose and velocity of the body.
        X_WB: Pose of the body in W.
        V_WB: Spatial velocity of the body in W.
    """
    off = mover.X_WM.translation() - X_WB.translation()
    turn = RotationMatrix(mover.X_WM.rotation() @ X_WB.rotation().inverse())
    angle = turn.ToAngleAxis()
    off_turn = angle.angle() * angle.axis()
    a = RATE**2 * off + 2.0 * RATE * (mover.v_WM - V_WB.translational())
    spin = RATE**2 * off_turn + 2.0 * RATE * (mover.w_WM - V_WB.rotational())
    inertia = MASS * TURNING_RADIUS**2
    return SpatialForce(inertia * spin, MASS * a)
