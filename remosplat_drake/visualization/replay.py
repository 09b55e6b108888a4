"""`record_replay`: makes an animation of a recorded run for the page."""

import dataclasses as dc
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import Diagram, DiagramBuilder

from remosplat_drake.recording.events import MOTION_STATUS, SUPERVISOR, Event
from remosplat_drake.recording.run_log import RunLog
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.motion_status import (
    HELD,
    MOVING,
    NOT_STARTED,
    MotionStatus,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_tiles import MAX_SURFELS
from remosplat_drake.visualization.motion_status_view import MotionStatusView
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.robot_view import (
    PUBLISH_PERIOD,
    AddRobotView,
)
from remosplat_drake.visualization.run_view import RunView
from remosplat_drake.visualization.scene_look import ROOT
from remosplat_drake.visualization.splat_view import draw_surfels
from remosplat_drake.visualization.toggle import on_off

SPLATS = f"{ROOT}/splat"

MAX_FRAMES = 4000
"""A replay has at most this many frames, each of about 2 kB. The replay of a
longer run has fewer frames per second."""


@dc.dataclass(frozen=True, eq=False)
class ReplayedMap:
    """A version of the map for a replay; a missing part is None.

    Attributes:
        field: Distance field that finds the closest scene points.
        splat_W: Splat in W that the page draws.
    """

    field: DistanceField | None = None
    splat_W: GaussianSplat | None = None


def record_replay(
    page: MeshcatPage,
    robot: RobotModel,
    log: RunLog,
    maps: Mapping[int, ReplayedMap],
    *,
    reach: float,
    events: Sequence[Event] = (),
    on_frame: Callable[[int, int], None] | None = None,
) -> None:
    """Records a logged run as an animation, which the page then plays.

    The animation shows robot, target and traces, and a red line from the robot
    to the closest point of the map. At each time it shows the map that the
    controller used. While an obstacle or a limit holds the robot, the affected
    link glows.

    Args:
        page: The page to draw on, which must be empty.
        robot: The robot of the run.
        log: Log of the run, with at least one tick.
        maps: All versions of the map in the log, keyed by number.
        reach: A line to a scene point is drawn only up to this distance [m].
        events: The run's events, in the order of their times.
        on_frame: Function that is called with the number of finished frames and
            the number of all frames.
    """
    time = log.rows["time"] - log.rows["time"][0]
    page.start_recording(0.0)
    draw_maps(page, maps, log.rows["map_version"], time)
    diagram = _make_diagram(page, robot)
    context = diagram.CreateDefaultContext()
    configuration, report, motion_status = map(diagram.get_input_port, range(3))
    ticks = frame_ticks(time)
    for done, k in enumerate(ticks.tolist()):
        row = log.rows[k]
        field = maps[int(row["map_version"])].field
        clearances = _clearances(field, robot, row["q"], reach)
        context.SetTime(time[k])
        configuration.FixValue(context, row["q"])
        report.FixValue(context, Value(log.report(k, clearances)))
        motion_status.FixValue(
            context, Value(motion_status_at(events, float(row["time"])))
        )
        diagram.ForcedPublish(context)
        if on_frame is not None:
            on_frame(done + 1, len(ticks))
    page.set_status("")
    page.finish_recording()


def frame_ticks(
    time: np.ndarray,
    period: float = PUBLISH_PERIOD,
    most: int = MAX_FRAMES,
) -> np.ndarray:
    """Chooses the ticks that become frames of an animation.

    The first and the last tick are always chosen.

    Args:
        time: Times of the ticks, increasing, shape (T,) [s].
        period: At least this much time passes between two frames [s].
        most: At most this many frames are chosen; must be at least 2.

    Returns:
        Indices of the ticks, ascending.
    """
    count = min(most, 1 + int((time[-1] - time[0]) / period))
    wanted = np.linspace(time[0], time[-1], max(count, 2))
    return np.unique(np.searchsorted(time, wanted).clip(max=len(time) - 1))


def motion_status_at(events: Sequence[Event], time: float) -> MotionStatus:
    """Returns the motion status at a time, from the events of the run.

    Args:
        events: The run's events, in the order of their times.
        time: The time, on the clock of the events [s].
    """
    told = (
        event
        for event in reversed(events)
        if event.kind in (MOTION_STATUS, SUPERVISOR) and event.time <= time
    )
    last = next(told, None)
    if last is None:
        return NOT_STARTED
    p_W = None if last.place is None else np.array(last.place)
    is_held = last.link != "" or p_W is not None
    kind = HELD if is_held else MOVING
    return MotionStatus(kind, last.text, link=last.link, p_W=p_W)


def draw_maps(
    page: MeshcatPage,
    maps: Mapping[int, ReplayedMap],
    versions: np.ndarray,
    time: np.ndarray,
) -> None:
    """Draws all maps of a run, each visible only while it was in use.

    The limit on the number of drawn discs holds for all maps together.

    Args:
        page: The page to draw on, which is recording.
        maps: All versions of the map in the log, keyed by number.
        versions: Version of the map at each tick, shape (T,).
        time: Times of the ticks in the recording, shape (T,) [s].
    """
    meshcat = page.meshcat
    drawn = {k: maps[k].splat_W for k in np.unique(versions).tolist()}
    splats = {k: splat for k, splat in drawn.items() if splat is not None}
    budget = MAX_SURFELS // max(1, len(splats))
    for version, splat in splats.items():
        path = f"{SPLATS}/{version}"
        draw_surfels(meshcat, path, splat, budget)
        is_asked = versions == version
        changed = np.flatnonzero(np.diff(is_asked)) + 1
        for k in (0, *changed.tolist()):
            page.scene.show(path, bool(is_asked[k]), float(time[k]))
    page.add_toggle(on_off("Splat", "1", SPLATS))


def _clearances(
    field: DistanceField | None, robot: RobotModel, q: np.ndarray, reach: float
) -> Clearances:
    if field is None or not np.isfinite(q).all():
        return Clearances.none()
    return field.clearances(robot.spheres_at(q), reach)


def _make_diagram(page: MeshcatPage, robot: RobotModel) -> Diagram:
    """Makes a diagram of the live page's views.

    The inputs of the diagram are configuration, report and motion_status.
    """
    builder = DiagramBuilder()
    run_view = RunView.AddToBuilder(builder, page=page, robot=robot)
    builder.ExportInput(run_view.GetInputPort("configuration"), "configuration")
    builder.ExportInput(run_view.GetInputPort("report"), "report")
    motion_status_view = MotionStatusView.AddToBuilder(
        builder, page=page, robot=robot
    )
    builder.ExportInput(
        motion_status_view.GetInputPort("motion_status"), "motion_status"
    )
    for port in (
        motion_status_view.GetInputPort("configuration"),
        AddRobotView(builder, robot, page),
    ):
        builder.ConnectInput("configuration", port)
    return builder.Build()
