"""A short run of a scenario that leaves a log, for the tests of recordings."""

import dataclasses as dc
from pathlib import Path

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem

from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.scenario_text import scenario_text
from remosplat_drake.app.stages.control import AddController, AddOracle
from remosplat_drake.app.stages.records import AddRecorder
from remosplat_drake.app.stages.station import MakeStation
from remosplat_drake.app.stages.supervision import AddSupervisor
from remosplat_drake.app.stages.targets import AddTargets
from remosplat_drake.app.world import World, load_world
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.mapping.store.map_file import write_map
from remosplat_drake.mapping.store.run_folders import new_run
from remosplat_drake.mapping.store.session import Session, Version
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.recording.trajectory_log import TrajectoryLog
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.station.connections import (
    AddConfiguration,
    AddMeasuredVelocity,
    ConnectCommand,
)

SWAP = 0.5
"""When the second map takes the place of the first [s]."""


class TwoMaps(LeafSystem):
    """Gives one map until `SWAP`, and then another."""

    def __init__(self, maps: tuple[SceneMap, SceneMap]):
        super().__init__()
        self._status = tuple(map(MapStatus, maps))
        for name, calc in (
            ("distance_field", self._calc_field),
            ("map_status", self._calc_status),
        ):
            self.DeclareAbstractOutputPort(
                name, Value[object]().Clone, calc, {self.time_ticket()}
            )

    def _now(self, context: Context) -> MapStatus:
        return self._status[context.get_time() >= SWAP]

    def _calc_field(self, context: Context, output: AbstractValue):
        output.set_value(self._now(context).scene_map.field)

    def _calc_status(self, context: Context, output: AbstractValue):
        output.set_value(self._now(context))


@dc.dataclass(frozen=True, eq=False)
class LoggedSession:
    """A session of one run, and what was known besides when it was made."""

    session: Session
    scenario: Scenario
    world: World
    maps: tuple[SceneMap, SceneMap]
    trajectory: Trajectory


def make_session(folder: Path, duration: float) -> LoggedSession:
    """A session of one run on the table, with a map that comes in between.

    The second map lacks half of the table.
    """
    scenario = load_scenario(
        "TableReach", "{controller: {guidance: {enabled: false}}}"
    )
    world = load_world(scenario)
    assert world.splat_W is not None
    session = Session.create(folder, scenario_text(scenario, "TableReach"))
    half = world.splat_W.select(world.splat_W.p_GK[:, 1] > 0)
    second = SceneMap(
        version=1,
        parent=0,
        frames=(),
        time=0.0,
        field=SphereToEllipsoidField(half),
        splat_W=half,
        quality="half",
    )
    first = dc.replace(
        second,
        version=0,
        parent=None,
        field=world.field,
        splat_W=world.splat_W,
        quality="all",
    )
    path = session.map_path(1)
    write_map(path, second)
    file = str(path.relative_to(folder))
    session.record(Version(1, 0, file, (), 0.1), set())
    maps = first, second
    trajectory = drive(new_run(folder), scenario, world, maps, duration)
    return LoggedSession(session, scenario, world, maps, trajectory)


def drive(
    folder: Path,
    scenario: Scenario,
    world: World,
    maps: tuple[SceneMap, SceneMap],
    duration: float,
) -> Trajectory:
    """Drives for so long, and logs it into a folder."""
    robot = world.robot
    builder = DiagramBuilder()
    two_maps = builder.AddSystem(TwoMaps(maps))
    station = builder.AddSystem(MakeStation(scenario, world, False))
    configuration = AddConfiguration(builder, robot, station)
    law = ReactiveLaw.make(scenario.controller, robot, scenario.control_period)
    targets = AddTargets(builder, scenario, world, configuration, law)
    oracle = AddOracle(builder, scenario, world, configuration)
    builder.Connect(
        two_maps.GetOutputPort("distance_field"),
        oracle.GetInputPort("distance_field"),
    )
    controller = AddController(builder, law, configuration, targets, oracle)
    supervisor = AddSupervisor(
        builder,
        scenario,
        robot,
        controller,
        station,
        AddMeasuredVelocity(builder, robot, station),
    )
    assert supervisor is not None
    executed = supervisor.GetOutputPort("velocity_commanded")
    ConnectCommand(builder, robot, executed, station)
    log = TrajectoryLog.AddToBuilder(
        builder,
        inputs={
            "report": controller.GetOutputPort("report"),
            "velocity_executed": executed,
            "supervision": supervisor.GetOutputPort("supervision"),
            "map_status": two_maps.GetOutputPort("map_status"),
        },
        folder=folder,
        n_q=robot.n_q,
        n_u=robot.n_u,
        period=scenario.control_period,
    )
    recorder = AddRecorder(
        builder, scenario, robot, configuration, controller, executed
    )
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(duration)
    log.close()
    assert not log.trouble
    return recorder.trajectory(
        recorder.GetMyContextFromRoot(simulator.get_context())
    )
