"""The scene's solids and the floor, as geometry of a plant."""

import numpy as np
import pytest
from pydrake.geometry import Role
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.station.scene_geometry import add_scene_geometry


def board(top: float) -> Box:
    return Box(RigidTransform([0.5, 0, top - 0.05]), np.array([0.4, 0.4, 0.05]))


@pytest.mark.parametrize(
    ("tops", "has_floor"),
    [([], True), ([0.5], True), ([0.0, 0.5], False), ([-0.2, 0.5], False)],
    ids=["empty", "a table", "its own floor", "a shelf below z = 0"],
)
def test_a_floor_is_added_where_the_scene_leaves_room_for_it(tops, has_floor):
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.01)
    scene = PrimitiveScene(boxes=tuple(board(top) for top in tops))
    add_scene_geometry(plant, scene, solid=True)
    plant.Finalize()
    inspector = scene_graph.model_inspector()
    for role in (Role.kProximity, Role.kIllustration):
        names = [
            inspector.GetName(geometry).split("::")[-1]
            for geometry in inspector.GetAllGeometryIds(role)
        ]
        assert len(names) == len(tops) + has_floor
        assert ("floor" in names) == has_floor
