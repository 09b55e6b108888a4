"""`MoverSensorSystem`: outputs the movers that a simulated robot senses."""

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
    State,
)

from remosplat_drake.scene.mover import Movers
from remosplat_drake.station.mover_sensing import MoverSensor

NOTHING = Movers(0.0)


class MoverSensorSystem(LeafSystem):
    """Applies a simulated sensor to the true movers.

    .. pydrake_system::

        name: MoverSensorSystem
        input_ports:
        - truth
        - configuration
        output_ports:
        - movers

    The input `truth` are the true `Movers`, and `configuration` is the robot's
    true q. The output `movers` are the movers that the sensor detects. If the
    sensor has a period, it measures once per period, and the output is constant
    between two measurements.

    Args:
        sensor: The sensor, which no other system may use.
        n_q: Length of the configuration.
    """

    def __init__(self, *, sensor: MoverSensor, n_q: int):
        super().__init__()
        self._sensor = sensor
        self._truth = self.DeclareAbstractInputPort("truth", Value[object]())
        self._configuration = self.DeclareVectorInputPort("configuration", n_q)
        if not sensor.period:
            self.DeclareAbstractOutputPort(
                "movers", Value[object](NOTHING).Clone, self._calc_movers
            )
            return
        self._cell = self.DeclareAbstractState(Value[object](NOTHING))
        self.DeclareInitializationUnrestrictedUpdateEvent(self._look)
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            sensor.period, sensor.period, self._look
        )
        self.DeclareStateOutputPort("movers", self._cell)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        sensor: MoverSensor,
        truth: OutputPort,
        configuration: OutputPort,
    ) -> OutputPort:
        """Adds the system to a diagram; returns the port of known movers.

        Args:
            builder: The builder of the diagram.
            sensor: The sensor.
            truth: The output port of the true `Movers`.
            configuration: The output port of the true q.
        """
        system = builder.AddNamedSystem(
            "mover_sensor",
            MoverSensorSystem(sensor=sensor, n_q=configuration.size()),
        )
        builder.Connect(truth, system.GetInputPort("truth"))
        builder.Connect(configuration, system.GetInputPort("configuration"))
        return system.GetOutputPort("movers")

    def _sense(self, context: Context) -> Movers:
        return self._sensor.sense(
            self._truth.Eval(context), self._configuration.Eval(context)
        )

    def _look(self, context: Context, state: State):
        cell = state.get_mutable_abstract_state(int(self._cell))
        cell.set_value(self._sense(context))

    def _calc_movers(self, context: Context, output: AbstractValue):
        output.set_value(self._sense(context))
