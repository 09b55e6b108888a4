"""`MoverSource`: outputs the true movers of a simulation."""

from collections.abc import Sequence

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import Context, LeafSystem

from remosplat_drake.scene.mover import Movers
from remosplat_drake.scene.moving.track import Track, movers_at


class MoverSource(LeafSystem):
    """Outputs the true poses and velocities of a scenario's movers.

    .. pydrake_system::

        name: MoverSource
        output_ports:
        - movers

    The output `movers` are the `Movers` at the context's time.

    Args:
        tracks: The motion of each mover.
    """

    def __init__(self, *, tracks: Sequence[Track]):
        LeafSystem.__init__(self)
        self.set_name("mover_source")
        self._tracks = tuple(tracks)
        self.DeclareAbstractOutputPort(
            "movers",
            lambda: Value[object](Movers(0.0)),
            self._calc_movers,
            {self.time_ticket()},
        )

    def _calc_movers(self, context: Context, output: AbstractValue):
        output.set_value(movers_at(self._tracks, context.get_time()))
