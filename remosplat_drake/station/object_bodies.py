"""Adds objects to a dynamic station as free bodies, and reads their poses."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem

from remosplat_drake.scene.objects.drake_shapes import (
    drake_shape,
    object_inertia,
)
from remosplat_drake.scene.objects.scene_object import SceneObject, check_names
from remosplat_drake.scene.primitive_scene import Cylinder
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.contact_materials import (
    object_material,
    scene_material,
)

OBJECTS = "objects"
"""Name of the model instance of all objects."""

COLOUR = np.array([0.30, 0.55, 0.75, 1.0])


def add_object_bodies(
    plant: MultibodyPlant, objects: Sequence[SceneObject], friction: float
) -> list[RigidBody]:
    """Adds a free body for each object, at its initial pose.

    An object of unknown mass, such as a table, is fixed to the world, and is
    compliant like the scene.

    Args:
        plant: A plant with a scene graph, before `Finalize`.
        objects: The objects.
        friction: Coefficient of friction of the objects.

    Raises:
        RemoSplatError: Two objects have the same name.
    """
    check_names(objects)
    if not objects:
        return []
    instance = plant.AddModelInstance(OBJECTS)
    bodies = []
    for thing in objects:
        body = plant.AddRigidBody(thing.name, instance, object_inertia(thing))
        shape, radius = drake_shape(thing.solid), 0.05
        if isinstance(thing.solid, Cylinder):
            radius = thing.solid.radius
        if thing.mass is None:
            W, material = plant.world_frame(), scene_material(radius)
            plant.WeldFrames(W, body.body_frame(), thing.X_WO)
        else:
            material = object_material(radius, friction)
            plant.SetDefaultFloatingBaseBodyPose(body, thing.X_WO)
        plant.RegisterVisualGeometry(
            body, RigidTransform(), shape, thing.name, COLOUR
        )
        plant.RegisterCollisionGeometry(
            body, RigidTransform(), shape, thing.name, material
        )
        bodies.append(body)
    return bodies


class ObjectReader(LeafSystem):
    """Outputs the poses of the objects in a plant.

    .. pydrake_system::

        name: ObjectReader
        input_ports:
        - body_poses
        output_ports:
        - cheat.objects

    `body_poses` is connected to the plant's port of this name. `cheat.objects`
    outputs the objects as a tuple of `SceneObject`, in the same order as at the
    start.
    """

    def __init__(
        self, *, objects: Sequence[SceneObject], bodies: Sequence[RigidBody]
    ):
        """Declares the ports.

        Args:
            objects: The objects.
            bodies: Bodies of the objects, in the same order.
        """
        super().__init__()
        self._objects = tuple(objects)
        self._bodies = [body.index() for body in bodies]
        self._poses = self.DeclareAbstractInputPort(
            "body_poses", AbstractValue.Make([RigidTransform()])
        )
        self.DeclareAbstractOutputPort(
            ports.CHEAT_OBJECTS,
            lambda: Value[object](),
            self._calc,
            {self._poses.ticket()},
        )

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        plant: MultibodyPlant,
        objects: Sequence[SceneObject],
        bodies: Sequence[RigidBody],
    ) -> None:
        """Adds the reader to a station, and exports its output.

        Args:
            builder: Builder of the station.
            plant: The finalized plant.
            objects: The objects.
            bodies: Bodies of the objects, in the same order.
        """
        reader = builder.AddNamedSystem(
            "object_reader", ObjectReader(objects=objects, bodies=bodies)
        )
        builder.Connect(
            plant.get_body_poses_output_port(), reader.get_input_port()
        )
        builder.ExportOutput(reader.get_output_port(), ports.CHEAT_OBJECTS)

    def _calc(self, context: Context, output: AbstractValue) -> None:
        poses = self._poses.Eval(context)
        output.set_value(
            tuple(
                thing.at(poses[body])
                for thing, body in zip(self._objects, self._bodies, strict=True)
            )
        )
