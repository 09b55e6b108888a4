"""Contact properties in the dynamic station: compliant pads, rigid objects.

If an object is held by two point contacts, it can rotate about the line through
the two points. To prevent this, fingers and objects have a contact patch:
fingers are compliant hydroelastic bodies, and objects are rigid hydroelastic
bodies. Scenes are compliant, too, but stiffer, so that the whole base of an
object is in contact. Other pairs, such as two objects or a link and the scene,
have point contact (Drake's `hydroelastic_with_fallback`).

Source of the model: Elandt et al., "A pressure field model for fast, robust
approximation of net contact force and moment between nominally rigid objects",
IROS 2019, and Drake's hydroelastic user guide.
"""

import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    ProximityProperties,
    RoleAssign,
    SceneGraph,
)
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody

from remosplat_drake.station.hand import HandGeometry

SCENE_MODULUS = 1e7
"""Hydroelastic modulus of the scene [Pa]."""

DISSIPATION = 5.0
"""Hunt-Crossley dissipation of scene, pads and objects [s/m]."""

SCENE_FRICTION = 0.6
"""Coefficient of friction of the scene."""

PAD_FRICTION = 1.5
"""Coefficient of friction of the pads."""

FACETS = 12
"""Number of sides of the polygon that represents a circle in contact."""

_PAD_EDGE = 0.01  # Of meshes on pads that are not convex polytopes [m].


def scene_material(size: float) -> ProximityProperties:
    """Returns the contact properties of a solid of the scene.

    Args:
        size: Smallest radius of the solid; any length for a box [m].
    """
    material = ProximityProperties()
    AddContactMaterial(
        dissipation=DISSIPATION,
        friction=CoulombFriction(SCENE_FRICTION, SCENE_FRICTION),
        properties=material,
    )
    edge = 2.0 * np.pi * size / FACETS
    AddCompliantHydroelasticProperties(edge, SCENE_MODULUS, material)
    return material


def object_material(radius: float, friction: float) -> ProximityProperties:
    """Returns the contact properties of an object.

    Args:
        radius: Radius of a round object, which determines the fineness of its
            contact mesh; any length for other objects [m].
        friction: Coefficient of friction of the object.
    """
    material = ProximityProperties()
    AddContactMaterial(
        dissipation=DISSIPATION,
        friction=CoulombFriction(friction, friction),
        properties=material,
    )
    AddRigidHydroelasticProperties(2.0 * np.pi * radius / FACETS, material)
    return material


def soften_pads(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    hand: HandGeometry,
    modulus: float,
) -> None:
    """Makes the fingers' collision geometry compliant.

    Args:
        plant: The finalized plant.
        scene_graph: The scene graph with its geometry.
        hand: Geometry of the gripper.
        modulus: Hydroelastic modulus of the pads [Pa].
    """
    source, inspector = plant.get_source_id(), scene_graph.model_inspector()
    assert source is not None
    for body in finger_bodies(plant, hand):
        for geometry in plant.GetCollisionGeometriesForBody(body):
            kept = inspector.GetProximityProperties(geometry)
            material = ProximityProperties(kept)
            for name in ("coulomb_friction", "hunt_crossley_dissipation"):
                if material.HasProperty("material", name):
                    material.RemoveProperty("material", name)
            AddContactMaterial(
                dissipation=DISSIPATION,
                friction=CoulombFriction(PAD_FRICTION, PAD_FRICTION),
                properties=material,
            )
            AddCompliantHydroelasticProperties(_PAD_EDGE, modulus, material)
            scene_graph.AssignRole(
                source, geometry, material, RoleAssign.kReplace
            )


def finger_bodies(plant: MultibodyPlant, hand: HandGeometry) -> list[RigidBody]:
    """Returns the finger bodies, and the bodies that are welded to them.

    Args:
        plant: The finalized plant.
        hand: Geometry of the gripper.
    """
    fingers = [plant.GetJointByName(x).child_body() for x in hand.joints]
    welded = [x for f in fingers for x in plant.GetBodiesWeldedTo(f)]
    indices = sorted({int(body.index()) for body in welded})
    return [plant.get_body(BodyIndex(index)) for index in indices]
