"""A diagram with a live map, ticked by hand."""

import time

import numpy as np
from mapped_table import looking_around
from patience import PATIENCE
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from remosplat_drake.app.world import World
from remosplat_drake.mapping.live_map import LiveMap
from remosplat_drake.mapping.mapping_process import MappingProcess
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.scene_map import SceneMap

PERIOD = 0.01
"""Time between two ticks [s]."""


class Station:
    """A robot that stands, an oracle, and a live map between them."""

    def __init__(self, world: World, process: MappingProcess, **options):
        self.world, self.process = world, process
        self.ticks = 0
        self.initial = SceneMap(0, None, (), -np.inf, world.field)
        builder = DiagramBuilder()
        q = builder.AddSystem(ConstantVectorSource(world.q0))
        self.q = q
        self.oracle = DistanceOracle.AddToBuilder(
            builder,
            robot=world.robot,
            field=world.field,
            max_distance=0.5,
            configuration=q.get_output_port(),
        )
        self.dut = LiveMap.AddToBuilder(
            builder,
            configuration=q.get_output_port(),
            oracle=self.oracle,
            process=process,
            initial=self.initial,
            n_q=world.robot.n_q,
            period=PERIOD,
            **options,
        )
        self.simulator = Simulator(builder.Build())
        self.root = self.simulator.get_mutable_context()
        self.context = self.dut.GetMyMutableContextFromRoot(self.root)
        self.ask(MapRequests())
        self.simulator.Initialize()

    def stand(self, q: np.ndarray) -> None:
        context = self.q.GetMyMutableContextFromRoot(self.root)
        self.q.get_mutable_source_value(context).SetFromVector(q)

    def ask(self, requests: MapRequests) -> None:
        port = self.dut.GetInputPort("requests")
        port.FixValue(self.context, Value(requests))

    def advance(self, ticks: int = 1) -> None:
        """To the middle between the last one of so many ticks and the next."""
        self.ticks += ticks
        self.simulator.AdvanceTo(self.latest + 0.5 * PERIOD)

    @property
    def latest(self) -> float:
        """Time of the latest tick [s]."""
        return (self.ticks - 1) * PERIOD

    @property
    def requests(self) -> MapRequests:
        """All that was asked for."""
        return self.dut.GetInputPort("requests").Eval(self.context)

    @property
    def status(self):
        return self.dut.status(self.context)

    @property
    def age(self) -> float:
        return self.dut.GetOutputPort("map_age").Eval(self.context)[0]

    @property
    def asked_field(self):
        """What the oracle asks."""
        context = self.oracle.GetMyContextFromRoot(self.root)
        return self.oracle.GetOutputPort("distance_field").Eval(context)

    def scan(self, count: int = 3) -> MapRequests:
        """Asks for frames from some poses; a map comes with the last one."""
        requests = self.requests
        poses = looking_around(self.world, count, seed=requests.frames)
        for i, q in enumerate(poses):
            self.stand(q)
            last = i == count - 1
            requests += MapRequests(frames=1, unfinished=0 if last else 1)
            self.ask(requests)
            self.advance()
        return requests

    def until_quiet(self) -> None:
        end = time.monotonic() + PATIENCE
        while self.status.is_building:
            assert time.monotonic() < end, "a map is built for ever"
            self.advance()
            time.sleep(0.005)
