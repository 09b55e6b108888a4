"""`SolidDistances`: distances of a moved solid from other solids."""

from collections.abc import Sequence
from typing import cast

import numpy as np
from pydrake.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    ProximityProperties,
    QueryObject,
    SceneGraph,
)
from pydrake.math import RigidTransform

from remosplat_drake.scene.objects.drake_shapes import drake_shape
from remosplat_drake.scene.objects.scene_object import Solid


class SolidDistances:
    """Computes, with Drake, distances of a movable solid from other solids.

    Args:
        moved: The solid that is moved.
        others: The k solids to which distances are measured, placed in W.
    """

    def __init__(self, moved: Solid, others: Sequence[Solid]):
        self._graph = SceneGraph()
        self._source = self._graph.RegisterSource("solids")
        self._frame = GeometryFrame("moved")
        self._graph.RegisterFrame(self._source, self._frame)
        self._moved = self._graph.RegisterGeometry(
            self._source,
            self._frame.id(),
            _instance("moved", moved, RigidTransform()),
        )
        self._others = [
            self._graph.RegisterAnchoredGeometry(
                self._source, _instance(f"other {i}", solid, solid.X_WP)
            )
            for i, solid in enumerate(others)
        ]
        self._context = self._graph.CreateDefaultContext()

    def at(self, X_WO: RigidTransform) -> np.ndarray:
        """Returns the distances, negative for overlaps, shape (k,) [m].

        Args:
            X_WO: Pose of the moved solid.
        """
        poses = FramePoseVector()
        poses.set_value(self._frame.id(), X_WO)
        port = self._graph.get_source_pose_port(self._source)
        port.FixValue(self._context, poses)
        output = self._graph.get_query_output_port()
        query = cast(QueryObject, output.Eval(self._context))
        return np.array(
            [
                query.ComputeSignedDistancePairClosestPoints(
                    self._moved, other
                ).distance
                for other in self._others
            ]
        )


def _instance(name: str, solid: Solid, X_WP: RigidTransform):
    instance = GeometryInstance(X_WP, drake_shape(solid), name)
    instance.set_proximity_properties(ProximityProperties())
    return instance
