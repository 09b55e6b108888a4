"""Stations: the kinematic one from elsewhere, and one that lacks a port."""

import dataclasses as dc

from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from remosplat_drake.base.ranges import Config
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_config import KinematicStation


@dc.dataclass
class Elsewhere(Config):
    """Ours, under another name."""

    name: str = "elsewhere"

    def make(self, robot, scene, q0, camera) -> Diagram:
        """Builds the station."""
        station = MakeSimulatedStation(
            config=KinematicStation(),
            robot=robot,
            scene=scene,
            q0=q0,
            wrist_camera=camera,
        )
        station.set_name(self.name)
        return station


@dc.dataclass
class Stump(Config):
    """Hardly a station."""

    def make(self, robot, scene, q0, camera) -> Diagram:
        """Builds a diagram with one wrong and one unknown port."""
        builder = DiagramBuilder()
        source = builder.AddSystem(ConstantVectorSource([0.0]))
        output = source.get_output_port()
        builder.ExportOutput(output, "panda.position_measured")
        builder.ExportOutput(output, "temperature")
        builder.ExportOutput(output, "cheat.temperature")
        return builder.Build()
