"""A station of your own, here a robot with drives that follow with a lag.

A station is a diagram with ports that all stations have. This one is the
kinematic station with a low-pass filter before its command ports. Select it by
`station: !my_module:LaggingStation {time_constant: 0.1}` in a scenario.
"""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import FirstOrderLowPassFilter

import remosplat_drake as rs
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_config import KinematicStation


@dc.dataclass
class LaggingStation(rs.Config):
    """The kinematic station, with slow drives."""

    # Time constant of the velocity error [s].
    time_constant: Annotated[float, Interval(gt=0, le=1)] = 0.05

    def make(self, robot, scene, q0, camera) -> Diagram:
        """Builds the station."""
        builder = DiagramBuilder()
        kinematic = MakeSimulatedStation(
            config=KinematicStation(), robot=robot, scene=scene, q0=q0
        )
        inner = builder.AddSystem(kinematic)
        for i in range(inner.num_input_ports()):
            port = inner.get_input_port(i)
            if not port.get_name().endswith("velocity_commanded"):
                builder.ExportInput(port, port.get_name())
                continue
            lag = FirstOrderLowPassFilter(self.time_constant, port.size())
            builder.AddSystem(lag)
            builder.Connect(lag.get_output_port(), port)
            builder.ExportInput(lag.get_input_port(), port.get_name())
        for i in range(inner.num_output_ports()):
            port = inner.get_output_port(i)
            builder.ExportOutput(port, port.get_name())
        return builder.Build()


def main() -> None:
    """Prints the robot's least distance with fast and with slow drives."""
    for time_constant in (0.01, 0.05):
        scenario = rs.load_scenario("TableReach")
        scenario.station = LaggingStation(time_constant)
        result = rs.run(rs.build(scenario))
        nearest = result.metrics.truth_clearance_min
        print(f"{time_constant:g} s: {result.outcome}, {nearest:.4f} m")


if __name__ == "__main__":
    main()
