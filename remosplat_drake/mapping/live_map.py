"""`LiveMap`: the system that uses the newest map of the mapping process."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
    State,
)

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.mapping.live_map_memory import (
    LiveMapMemory,
    changed,
    located,
    news,
    taken_back,
)
from remosplat_drake.mapping.localization.base_localization import SIGMAS
from remosplat_drake.mapping.map_status import first_status, noted
from remosplat_drake.mapping.mapping_process import MappingProcess
from remosplat_drake.mapping.messages import (
    Event,
    Located,
    MapReady,
    Track,
)
from remosplat_drake.mapping.store.map_file import open_map
from remosplat_drake.oracle.uncertain_placement import UncertainPlacement
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.planar_pose import largest_error
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.base_correction import BaseCorrection
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.optional_input import value_or_none
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.signals.task_surroundings import TaskSurroundings

_AHEAD = 1.0
"""A camera's clock may be ahead of the control clock by at most this time [s].
"""

_TRACKING_PERIOD = 0.2
"""Time between two localisations of the base [s]."""

_ROUNDING = 1e-9
"""The rounding error of a tick's time is below this limit [s]."""


class LiveMap(LeafSystem):
    """Sends requests to the mapping process, and outputs its newest map.

    .. pydrake_system::

        name: LiveMap
        input_ports:
        - configuration
        - requests (optional)
        - settled (optional)
        - passing (optional)
        - velocity_executed (optional)
        - surroundings (optional)
        output_ports:
        - distance_field
        - map_age
        - map_status
        - correction
        - hold

    This system never waits for the process. At a tick, it maps the file of a
    new map into memory, and the map takes effect from the next tick on.

    The input `velocity_executed` is the command u. If it is connected, the map
    and the base pose are replaced at the same instant, half-way between two
    ticks, and only if `objection` returns no reason against it. Otherwise
    `hold` outputs this reason for a supervisor, which stops the robot, and
    `objection` is called again at every tick.

    The other inputs are the measured `configuration` q, the `MapRequests` of
    operators (`requests`), the `MapRequests` for movers that have come to rest
    (`settled`), and the `Movers` that still move (`passing`), which are masked
    in frames. `surroundings` takes the `TaskSurroundings` of an operator's
    jobs, whose objects are not in the map. The outputs are the map's
    `DistanceField`, a `MapStatus`, the newest `BaseCorrection` of any map, and
    `map_age`, the age of the map's newest frame [s], which is 0 before the
    first frame.

    With a fixed latency, a map in a simulation takes effect exactly this time
    after its request. If necessary, the simulation waits for the map.

    Args:
        process: The process that takes the pictures and builds the maps.
        initial: The scenario's map, version 0.
        n_q: Length of a configuration.
        period: Time between two polls of the process [s].
        reopened: The map of a continued session; None for a new session.
        latency: The fixed latency [s]; with None, maps take effect as soon as
            they are built.
        tracking: Whether the base is localised between the frames of maps, too.
        objection: Function of a field, a configuration q, a command u and a
            payload (or None). It returns the reason why the field must not take
            effect while the robot is at q, executes u and carries the payload.
            An empty string permits the field. None permits every field.
        n_u: Length of a command.
    """

    def __init__(
        self,
        *,
        process: MappingProcess,
        initial: SceneMap,
        n_q: int,
        period: float,
        reopened: SceneMap | None = None,
        latency: float | None = None,
        tracking: bool = False,
        objection: Callable[
            [DistanceField, np.ndarray, np.ndarray, Payload | None], str
        ]
        | None = None,
        n_u: int = 0,
    ):
        super().__init__()
        self.set_name("live_map")
        self._process = process
        self._initial = initial
        self._latency = latency
        self._tracking = tracking
        self._objection = objection
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", n_q
        )
        self._requests_input = self.DeclareAbstractInputPort(
            "requests", Value(MapRequests())
        )
        self._settled_input = self.DeclareAbstractInputPort(
            "settled", Value(MapRequests())
        )
        self._passing_input = self.DeclareAbstractInputPort(
            "passing", Value[object](Movers(0.0))
        )
        self._executed_input = self.DeclareVectorInputPort(
            "velocity_executed", n_u
        )
        self._surroundings_input = self.DeclareAbstractInputPort(
            "surroundings", Value[object]()
        )
        status = first_status(initial if reopened is None else reopened)
        before = LiveMapMemory(status)
        if process.sent:  # A map is being built before the first tick.
            status = dc.replace(status, is_building=True)
            due = () if latency is None else ((latency, process.sent, True),)
            before = LiveMapMemory(status, due=due)
        self._memory_index = self.DeclareAbstractState(Value(before))
        memory = self.abstract_state_ticket(self._memory_index)
        self.DeclareAbstractOutputPort(
            "distance_field",
            Value[object]().Clone,
            self._calc_field,
            {memory},
        )
        self.DeclareVectorOutputPort(
            "map_age", 1, self._calc_age, {memory, self.time_ticket()}
        )
        self.DeclareAbstractOutputPort(
            "map_status", Value(status).Clone, self._calc_status, {memory}
        )
        self.DeclareAbstractOutputPort(
            "correction",
            Value(BaseCorrection()).Clone,
            self._calc_correction,
            {memory},
        )
        self.DeclareAbstractOutputPort(
            "hold", Value("").Clone, self._calc_hold, {memory}
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._tick)
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            period, 0.5 * period, self._change
        )

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        configuration: OutputPort,
        requests: OutputPort | None = None,
        settled: OutputPort | None = None,
        passing: OutputPort | None = None,
        oracle: LeafSystem,
        jobs: LeafSystem | None = None,
        supervisor: LeafSystem | None = None,
        executed: OutputPort | None = None,
        localization: LeafSystem | None = None,
        **arguments,
    ) -> "LiveMap":
        """Adds a live map to a diagram, and connects it.

        Args:
            builder: Builder of the diagram.
            configuration: The measured configuration q, not corrected.
            requests: The `MapRequests` of operators; None if there are none.
            settled: The `MapRequests` for movers that have come to rest; None
                if there are none.
            passing: The `Movers` that still move; None if there are none.
            oracle: The distance oracle, which is connected to the live map.
            jobs: The system of an operator's jobs, which adds objects to the
                map. If given, it is connected to the live map in place of the
                oracle.
            supervisor: The safety supervisor, which receives the map's age and
                the reason why a new map does not take effect; None if there is
                none.
            executed: The command u that the station executes; with None, maps
                take effect without a check.
            localization: The system that corrects the base's odometry; None if
                there is none.
            **arguments: The arguments of `LiveMap`.
        """
        live_map = builder.AddSystem(LiveMap(**arguments))
        builder.Connect(configuration, live_map.GetInputPort("configuration"))
        if requests is not None:
            builder.Connect(requests, live_map.GetInputPort("requests"))
        if settled is not None:
            builder.Connect(settled, live_map.GetInputPort("settled"))
        if passing is not None:
            builder.Connect(passing, live_map.GetInputPort("passing"))
        field = live_map.GetOutputPort("distance_field")
        if jobs is None:
            builder.Connect(field, oracle.GetInputPort("distance_field"))
        else:
            builder.Connect(field, jobs.GetInputPort("scene"))
            builder.Connect(
                jobs.GetOutputPort("surroundings"),
                live_map.GetInputPort("surroundings"),
            )
        if supervisor is not None:
            builder.Connect(
                live_map.GetOutputPort("map_age"),
                supervisor.GetInputPort("map_age"),
            )
            builder.Connect(
                live_map.GetOutputPort("hold"),
                supervisor.GetInputPort("map_hold"),
            )
        if executed is not None:
            builder.Connect(
                executed, live_map.GetInputPort("velocity_executed")
            )
        if localization is not None:
            builder.Connect(
                live_map.GetOutputPort("correction"),
                localization.GetInputPort("correction"),
            )
        return live_map

    def status(self, context: Context) -> MapStatus:
        """Returns the present status.

        Args:
            context: The system's own context.
        """
        return self._memory(context).status

    def _memory(self, context: Context) -> LiveMapMemory:
        return context.get_abstract_state(int(self._memory_index)).get_value()

    def _calc_field(self, context: Context, output: AbstractValue):
        output.set_value(self.status(context).scene_map.field)

    def _calc_age(self, context: Context, output: BasicVector):
        now, taken = context.get_time(), self.status(context).scene_map.time
        if taken > now + _AHEAD:  # Of an earlier run, with another clock.
            taken = 0.0
        age = now - taken if np.isfinite(taken) else 0.0
        output.SetAtIndex(0, max(0.0, age))

    def _calc_status(self, context: Context, output: AbstractValue):
        output.set_value(self.status(context))

    def _calc_correction(self, context: Context, output: AbstractValue):
        output.set_value(self._memory(context).correction)

    def _calc_hold(self, context: Context, output: AbstractValue):
        output.set_value(self._memory(context).hold)

    def _change(self, context: Context, state: State):
        memory = self._memory(context)
        if memory.candidate is None:
            return
        cell = state.get_mutable_abstract_state(int(self._memory_index))
        cell.set_value(changed(memory, self._asked_whether(context, memory)))

    def _asked_whether(self, context: Context, memory: LiveMapMemory) -> str:
        """Returns the objection to the waiting map."""
        if self._objection is None or memory.candidate is None:
            return ""
        scene_map, correction = memory.candidate
        q = np.array(self._configuration_input.Eval(context))
        field, payload = scene_map.field, None
        around = self._surroundings(context)
        if around is not None:
            field, payload = around.field(field), around.payload
        if correction.estimate is not None:
            q[:3], P = correction.base_at(context.get_time(), q[:3])
            off = largest_error(P, SIGMAS, q[:3], q[:3])
            field = UncertainPlacement(field, q[:2], *off)
        u = self._executed_input.Eval(context)
        return self._objection(field, q, u, payload)

    def _tick(self, context: Context, state: State):
        before = self._memory(context)
        memory = self._followed(context, self._asked(context, before))
        memory = self._heard(context.get_time(), memory)
        if memory is not before:
            cell = int(self._memory_index)
            state.get_mutable_abstract_state(cell).set_value(memory)

    def _asked(self, context: Context, memory: LiveMapMemory) -> LiveMapMemory:
        """Sends new requests to the mapping process."""
        ports = self._requests_input, self._settled_input
        asked = [port.Eval(context) for port in ports if port.HasValue(context)]
        wanted = sum(asked, MapRequests())
        if wanted == memory.known:
            return memory
        q, time = self._configuration_input.Eval(context), context.get_time()
        around, passing = self._surroundings(context), self._passing(context)
        objects = () if around is None else around.placed(q)
        requests = news(memory.known, wanted, q, time, passing, objects)
        for request in requests:
            self._process.request(request)
        memory = dc.replace(memory, known=wanted)
        if not requests:
            return memory
        due = memory.due
        if self._latency is not None:
            due = (*due, (time + self._latency, self._process.sent, True))
        status = dc.replace(memory.status, is_building=True)
        return dc.replace(memory, status=status, due=due)

    def _followed(
        self, context: Context, memory: LiveMapMemory
    ) -> LiveMapMemory:
        """Requests a localisation of the base, if one is due."""
        time = context.get_time()
        is_due = time >= memory.tracked + _TRACKING_PERIOD - _ROUNDING
        if not self._tracking or not is_due:
            return memory
        q = self._configuration_input.Eval(context)
        request = Track(q, time, self._passing(context))
        if self._latency is None:
            self._process.track(request)
            return dc.replace(memory, tracked=time)
        self._process.request(request)
        answer = time + self._latency, self._process.sent, False
        due = (*memory.due, answer)
        return dc.replace(memory, tracked=time, due=due)

    def _passing(self, context: Context) -> Movers:
        """Returns the known movers that have not settled."""
        return value_or_none(self._passing_input, context) or Movers(0.0)

    def _surroundings(self, context: Context) -> TaskSurroundings | None:
        """Returns the objects of an operator's jobs; None without jobs."""
        return value_or_none(self._surroundings_input, context)

    def _heard(self, time: float, memory: LiveMapMemory) -> LiveMapMemory:
        """Processes events of the mapping process."""
        due = memory.due
        if self._latency is None:
            events = self._process.poll()
        else:
            events = []
            while due and time >= due[0][0] - _ROUNDING:
                events += self._process.wait(due[0][1])
                due = due[1:]
        if not events:
            return memory
        for event in events:
            memory = self._after(memory, event)
        if self._objection is None:
            memory = changed(memory, "")
        is_building = self._process.answered < self._process.sent
        if self._latency is not None:
            is_building = any(makes_map for *_, makes_map in due)
        status = dc.replace(memory.status, is_building=is_building)
        return dc.replace(memory, status=status, due=due)

    def _after(self, memory: LiveMapMemory, event: Event) -> LiveMapMemory:
        if isinstance(event, Located):
            return located(memory, event.correction)
        if not isinstance(event, MapReady):
            return dc.replace(memory, status=noted(memory.status, event))
        correction = event.correction or BaseCorrection()
        if event.version == memory.status.scene_map.version:
            return located(taken_back(memory), correction)
        try:
            scene_map = (
                self._initial
                if event.path is None
                else open_map(event.path, event.seal)
            )
        except RemoSplatError as error:
            trouble = f"the previous map stays in use: {error}"
            status = dc.replace(memory.status, trouble=trouble)
            return dc.replace(memory, status=status)
        correction = dc.replace(correction, version=event.version)
        return dc.replace(memory, candidate=(scene_map, correction))
