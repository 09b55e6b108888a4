"""The scene's solids and the floor, as geometry of a plant."""

import numpy as np
import pytest
from pydrake.geometry import Role
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.station.scene_geometry import add_scene_geometry


def board(bottom: float, top: float) -> Box:
    half = 0.5 * (top - bottom)
    return Box(RigidTransform([0.5, 0, top - half]), np.array([0.4, 0.4, half]))


@pytest.mark.parametrize(
    ("spans", "has_floor"),
    [
        ([], True),
        ([(0.4, 0.5), (-0.02, 0.4)], True),
        ([(-0.1, 0.0), (0.0, 0.5)], False),
        ([(-0.3, -0.2), (0.4, 0.5)], False),
        ([(-0.4, 0.2), (0.2, 0.3)], False),
    ],
    ids=["empty", "table", "its own floor", "shelf below z = 0", "long leg"],
)
def test_a_floor_is_added_where_the_scene_leaves_room_for_it(spans, has_floor):
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.01)
    scene = PrimitiveScene(boxes=tuple(board(*span) for span in spans))
    add_scene_geometry(plant, scene, solid=True)
    plant.Finalize()
    inspector = scene_graph.model_inspector()
    for role in (Role.kProximity, Role.kIllustration):
        names = [
            inspector.GetName(geometry).split("::")[-1]
            for geometry in inspector.GetAllGeometryIds(role)
        ]
        assert len(names) == len(spans) + has_floor
        assert ("floor" in names) == has_floor
