"""`SettledRequests`: the system that requests map frames of objects at rest."""

from collections.abc import Callable

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
    State,
)

from remosplat_drake.detection.settled_things import SettledThings
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.map_requests import MapRequests

_PERIOD = 0.1
"""Time between two updates [s]."""


class SettledRequests(LeafSystem):
    """Requests another frame for the live map if an object stays at rest.

    .. pydrake_system::

        name: SettledRequests
        input_ports:
        - configuration
        - movers
        output_ports:
        - map_requests
        - passing

    `configuration` is the robot's q, and `movers` are the `Movers` that cameras
    detect. `map_requests` is a `MapRequests` for another frame, whenever an
    object in view of the map's camera has been at rest for the time `settle`.
    Until a version of the map contains this object, it remains one of the
    movers. `passing` are the `Movers` that have not settled, which no frame of
    a map should contain.

    Args:
        in_view: Function of q and a point in W, shape (3,) [m], that returns
            whether the map's camera can see the point.
        n_q: Length of a configuration.
        settle: Time after which an object at rest has settled [s].
    """

    def __init__(
        self,
        *,
        in_view: Callable[[np.ndarray, np.ndarray], bool],
        n_q: int,
        settle: float,
    ):
        super().__init__()
        self.set_name("settled_requests")
        self._in_view, self._settle = in_view, settle
        self._configuration = self.DeclareVectorInputPort("configuration", n_q)
        self._movers = self.DeclareAbstractInputPort(
            "movers", Value[object](Movers(0.0))
        )
        self._things = self.DeclareAbstractState(Value[object](SettledThings()))
        self.DeclarePeriodicUnrestrictedUpdateEvent(_PERIOD, 0.0, self._look)
        self.DeclareAbstractOutputPort(
            "map_requests",
            Value(MapRequests()).Clone,
            self._calc_requests,
            {self.abstract_state_ticket(self._things)},
        )

        self.DeclareAbstractOutputPort(
            "passing",
            Value[object](Movers(0.0)).Clone,
            self._calc_passing,
            {
                self.abstract_state_ticket(self._things),
                self._movers.ticket(),
            },
        )

    def _look(self, context: Context, state: State) -> None:
        q = self._configuration.Eval(context)
        things = self._known(context).after(
            self._movers.Eval(context),
            context.get_time(),
            lambda p_W: self._in_view(q, p_W),
            self._settle,
        )
        state.get_mutable_abstract_state(int(self._things)).set_value(things)

    def _known(self, context: Context) -> SettledThings:
        return context.get_abstract_state(int(self._things)).get_value()

    def _calc_requests(self, context: Context, output: AbstractValue) -> None:
        output.set_value(MapRequests(frames=self._known(context).asked))

    def _calc_passing(self, context: Context, output: AbstractValue) -> None:
        movers = self._movers.Eval(context)
        output.set_value(self._known(context).passing(movers))

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        configuration: OutputPort,
        movers: OutputPort,
        **arguments,
    ) -> "SettledRequests":
        """Adds the system, and connects its inputs.

        Args:
            builder: The builder of the diagram.
            configuration: The output port of the robot's q.
            movers: The output port of the detected `Movers`.
            **arguments: The arguments of `SettledRequests`, except for
                `n_q`.
        """
        system = builder.AddSystem(
            SettledRequests(n_q=configuration.size(), **arguments)
        )
        builder.Connect(configuration, system.GetInputPort("configuration"))
        builder.Connect(movers, system.GetInputPort("movers"))
        return system
