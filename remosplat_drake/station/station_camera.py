"""`StationCamera`: what a station wants of a camera that it takes along."""

from typing import Protocol

from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort


class StationCamera(Protocol):
    """A camera that a station takes along."""

    def AddToStation(
        self,
        builder: DiagramBuilder,
        plant: MultibodyPlant,
        scene_graph: SceneGraph,
    ) -> dict[str, OutputPort]:
        """Adds the camera, and gives its ports by the station's names.

        Args:
            builder: Builder of the station.
            plant: The finalized plant that poses the geometry.
            scene_graph: What is rendered.
        """
        ...
