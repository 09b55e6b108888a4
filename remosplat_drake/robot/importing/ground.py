"""Finds the lowest points of a robot's links with all joints at zero."""

from pathlib import Path

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.tree import BodyIndex

from remosplat_drake.robot.fitting.link_surface import collision_surface
from remosplat_drake.robot.fitting.model_surfaces import load_model


def lowest_points(model: Path) -> dict[str, float]:
    """Computes the height of the lowest point of each link [m].

    Args:
        model: A URDF, whose base link is at the origin.

    Returns:
        Heights by link name; links without collision shapes are left out.

    Raises:
        FileError: Drake cannot read the model.
    """
    scene_graph = SceneGraph()
    plant = load_model(model, scene_graph)
    context = plant.CreateDefaultContext()
    rng = np.random.default_rng(0)
    lowest = {}
    for i in range(plant.num_bodies()):
        body = plant.get_body(BodyIndex(i))
        p_LP = collision_surface(
            plant, scene_graph.model_inspector(), body.name(), 0.02, rng
        )
        if len(p_LP):
            X_WL = plant.EvalBodyPoseInWorld(context, body)
            lowest[body.name()] = float((X_WL @ p_LP.T)[2].min())
    return lowest
