"""Builds the application: all stages, connected in one diagram.

`control_loop.py` closes the loop; `stages/` makes and connects each stage.
"""

import dataclasses as dc
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from remosplat_drake.app.control_loop import AddControlLoop, ControlLoop
from remosplat_drake.app.other_robots import AddOtherRobots, with_right_of_way
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.scene_config import OBSTACLE
from remosplat_drake.app.stages.log import AddLog
from remosplat_drake.app.stages.records import AddRecorder
from remosplat_drake.app.stages.supervision import AddPanel
from remosplat_drake.app.stages.targets import AddTargets
from remosplat_drake.app.stages.task import task_port
from remosplat_drake.app.world import World, load_world
from remosplat_drake.base.ranges import check_ranges
from remosplat_drake.controller.program.ingredient import Ingredient
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.recording.mcap.mcap_recorder import McapRecorder
from remosplat_drake.recording.trajectory_log import TrajectoryLog
from remosplat_drake.recording.trajectory_recorder import TrajectoryRecorder
from remosplat_drake.visualization.log_view import LogView
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.safety_panel import SafetyPanel
from remosplat_drake.visualization.unseen_space import show_unseen_space
from remosplat_drake.visualization.views import AddViews

# Modules that make maps are imported only where they are used, since their
# import takes long and most runs do not need them.
if TYPE_CHECKING:
    from remosplat_drake.app.stages.teleoperation import Teleoperation
    from remosplat_drake.cockpit.cockpit_process import CockpitProcess
    from remosplat_drake.mapping.live_map import LiveMap

KEPT = 10.0
"""A teleoperation removes ticks that are older than this from memory [s]. Its
log on disk contains all ticks."""


@dc.dataclass(frozen=True, eq=False)
class Application(ControlLoop):
    """A built diagram, and the parts that a run reads.

    Attributes:
        diagram: Drake's diagram of all stages.
        recorder: The system that keeps the ticks of the run in memory.
        live_map: The map that grows during a teleoperation; None without a live
            map.
        log: The system that writes the ticks of a teleoperation, or an MCAP
            file, to disk; None in other runs.

    Example:
        >>> import remosplat_drake as rs
        >>> application = rs.build(rs.load_scenario("TableReach"))
        >>> application.diagram.get_name()
        'remosplat'
    """

    diagram: Diagram
    recorder: TrajectoryRecorder
    live_map: "LiveMap | None" = None
    log: TrajectoryLog | None = None


def build(
    scenario: Scenario,
    world: World | None = None,
    page: MeshcatPage | None = None,
    *,
    hardware: bool = False,
    teleoperation: "Teleoperation | None" = None,
    ingredients: Sequence[Ingredient] = (),
    law: ReactiveLaw | None = None,
    mcap: McapRecorder | None = None,
    cockpit: "CockpitProcess | None" = None,
) -> Application:
    """Builds one diagram of a scenario's stages.

    Args:
        scenario: The scenario that the stages are made from.
        world: The content of the scenario's files; None reads them.
        page: A browser page to draw on; None draws nothing.
        hardware: Whether the station is the real robot. All other stages are
            the same as in a simulation.
        teleoperation: The inputs of a teleoperation, in which an operator moves
            the target and the map grows. None means a run with the scenario's
            targets.
        ingredients: Costs and constraints that are added to the scenario's
            control law; rollouts include them, too.
        law: A control law that replaces the scenario's; None means the
            scenario's control law.
        mcap: Writer of the run as an MCAP file; None writes no such file.
        cockpit: The page of a teleoperation's operator; None without this page.

    Raises:
        RemoSplatError: A file is unusable, the station cannot be made, or
            there is no target.

    Example:
        >>> import remosplat_drake as rs
        >>> application = rs.build(rs.load_scenario("TableGroundTruth"))
        >>> dot = application.diagram.GetGraphvizString(max_depth=1)
    """
    # A field may have changed since the scenario was read.
    check_ranges(scenario, scenario.source)
    world = world or load_world(scenario)
    scenario = with_right_of_way(scenario)
    builder = DiagramBuilder()
    panel = AddPanel(builder, scenario, world.robot, page, hardware=hardware)
    operation = None
    add_targets = partial(
        AddTargets, builder, scenario, world, hardware=hardware
    )
    if teleoperation is not None:
        from remosplat_drake.app.stages.operation import Operation

        operation = Operation(
            builder, teleoperation, page, cockpit, hardware=hardware
        )
        add_targets = partial(operation.AddTarget, scenario, world)
    loop = AddControlLoop(
        builder,
        scenario,
        world,
        add_targets,
        hardware=hardware,
        ingredients=ingredients,
        law=law,
        others=partial(AddOtherRobots, builder, scenario, world)
        if not hardware
        else lambda *_: (),
    )
    _ConnectPanel(builder, loop, panel, operation and operation.operator)
    recorder = AddRecorder(
        builder,
        scenario,
        world.robot,
        loop.configuration,
        loop.controller,
        loop.executed,
        loop.true_movers,
        keep=None if operation is None else KEPT,
    )
    live_map = operation and operation.AddMap(loop)
    log = None
    if teleoperation is not None or mcap is not None:
        folder = teleoperation and teleoperation.run
        target = operation and operation.target
        log = AddLog(builder, loop, folder, live_map, target, mcap)
    if page is not None:
        _AddWorldViews(builder, loop, page, live_map)
        if not hardware:
            from remosplat_drake.app.stages.offers import AddPageOffers

            AddPageOffers(builder, loop, page)
    if page is not None and log is not None:
        LogView.AddToBuilder(
            builder, page=page, trouble=log.GetOutputPort("trouble")
        )
    if operation is not None:
        operation.AddViews(loop, live_map)
    diagram = builder.Build()
    diagram.set_name("remosplat")
    parts = {f.name: getattr(loop, f.name) for f in dc.fields(loop)}
    return Application(
        **parts,
        diagram=diagram,
        recorder=recorder,
        live_map=live_map,
        log=log,
    )


def _ConnectPanel(
    builder: DiagramBuilder,
    loop: ControlLoop,
    panel: SafetyPanel | None,
    operator: LeafSystem | None,
) -> None:
    """Connects the page's panel, or else an operator, to the supervisor."""
    if loop.supervisor is None:
        return
    if panel is not None:
        panel.ConnectTo(
            builder,
            supervisor=loop.supervisor,
            report=loop.report,
            status=loop.status,
            motion_status=loop.motion_status.GetOutputPort("motion_status"),
        )
    elif operator is not None:
        builder.Connect(
            operator.GetOutputPort("operator"),
            loop.supervisor.GetInputPort("operator"),
        )


def _AddWorldViews(
    builder: DiagramBuilder,
    loop: ControlLoop,
    page: MeshcatPage,
    live_map: "LiveMap | None",
) -> None:
    """Adds the systems that draw the scene, the robot and its guidance.

    A live map is drawn by the views of the teleoperation.
    """
    world, selector = loop.world, loop.selector
    AddViews(
        builder,
        page,
        robot=world.robot,
        splat_W=world.splat_W if live_map is None else None,
        truth=world.truth,
        configuration=loop.configuration,
        report=loop.report,
        motion_status=loop.motion_status.GetOutputPort("motion_status"),
        selection=selector and selector.GetOutputPort("selection"),
        movers=loop.movers,
        objects=task_port(loop.targets, "objects"),
        outline=task_port(loop.targets, "outline"),
    )
    if world.seen is not None and live_map is None:
        show_unseen_space(
            page,
            world.seen.coverage,
            world.seen.X_WG,
            shown=loop.scenario.scene.unknown == OBSTACLE,
        )
