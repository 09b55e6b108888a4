"""`BaseUncertainty`: reads the bound of the base's pose error from a status."""

from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    Diagram,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.signals import station_ports as ports
from remosplat_drake.signals.station_status import StationStatus


class BaseUncertainty(LeafSystem):
    """Outputs the bound of the base's pose error from a station's status.

    .. pydrake_system::

        name: BaseUncertainty
        input_ports:
        - status
        output_ports:
        - base_uncertainty

    The output is the bound of the position and the heading error [m, rad] in
    `StationStatus.base_uncertainty`.
    """

    def __init__(self):
        """Declares the ports."""
        super().__init__()
        self.set_name("base_uncertainty")
        self._status = self.DeclareAbstractInputPort(
            "status", Value(StationStatus())
        )
        self.DeclareVectorOutputPort(
            "base_uncertainty", 2, self._calc, {self._status.ticket()}
        )

    @staticmethod
    def AddToBuilder(builder: DiagramBuilder, station: Diagram) -> OutputPort:
        """Adds the system to a diagram, and connects it with a station.

        Args:
            builder: Builder of the diagram that contains the station.
            station: A simulated or the real station.

        Returns:
            The output port of the bound, a vector of 2 entries.
        """
        system = builder.AddSystem(BaseUncertainty())
        builder.Connect(
            station.GetOutputPort(ports.STATUS), system.GetInputPort("status")
        )
        return system.get_output_port()

    def _calc(self, context: Context, output: BasicVector):
        output.SetFromVector(self._status.Eval(context).base_uncertainty)
