"""`MapAnnouncer`: the system that publishes the version of the map in use."""

from collections.abc import Callable
from time import time

from pydrake.common.value import Value
from pydrake.lcm import DrakeLcmInterface
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.hardware.wire.counting import (
    PERIOD,
    CountingMap,
    encode_counting,
)
from remosplat_drake.signals.map_status import MapStatus


class MapAnnouncer(LeafSystem):
    """Publishes the version of the live map that a control loop uses.

    .. pydrake_system::

        name: MapAnnouncer
        input_ports:
        - map_status

    `map_status` is the live map's `MapStatus`. `remosplat detect` receives the
    version and uses the same map, so it does not report objects that this map
    contains.

    Args:
        lcm: The LCM network.
        channel: Name of the channel.
        clock: Function that returns the wall-clock time [s].
    """

    def __init__(
        self,
        *,
        lcm: DrakeLcmInterface,
        channel: str,
        clock: Callable[[], float] = time,
    ):
        super().__init__()
        self.set_name("map_announcer")
        self._lcm, self._channel, self._clock = lcm, channel, clock
        self._status = self.DeclareAbstractInputPort(
            "map_status", Value[object]()
        )
        self.DeclarePeriodicPublishEvent(PERIOD, 0.0, self._say)

    def _say(self, context: Context) -> None:
        status: MapStatus = self._status.Eval(context)
        counting = counting_of(status)
        packet = encode_counting(counting, self._clock())
        self._lcm.Publish(self._channel, packet)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, map_status: OutputPort, **arguments
    ) -> "MapAnnouncer":
        """Adds the system, and connects its input.

        Args:
            builder: The builder of the diagram.
            map_status: The output port of the live map's `MapStatus`.
            **arguments: The arguments of `MapAnnouncer`.
        """
        system = builder.AddSystem(MapAnnouncer(**arguments))
        builder.Connect(map_status, system.GetInputPort("map_status"))
        return system


def counting_of(status: MapStatus) -> CountingMap:
    """Returns the version of a live map that is in use.

    Args:
        status: The live map's status.
    """
    scene_map = status.scene_map
    return CountingMap(scene_map.version, scene_map.field.revision)
