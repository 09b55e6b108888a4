"""`StationCamera`: protocol of a simulated station's wrist camera."""

from typing import Protocol

from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort


class StationCamera(Protocol):
    """Protocol of settings that add a camera to a simulated station.

    `camera.WristCameraConfig` implements it.
    """

    def AddToStation(
        self,
        builder: DiagramBuilder,
        plant: MultibodyPlant,
        scene_graph: SceneGraph,
    ) -> dict[str, OutputPort]:
        """Adds the camera to a station's diagram.

        Args:
            builder: Builder of the station.
            plant: The finalized plant, which determines the poses of the
                geometry.
            scene_graph: Scene graph with the geometry to render.

        Returns:
            The camera's output ports, keyed by their names in
            `signals.station_ports`.
        """
        ...
