"""`CockpitView`: sends the robot's state to the cockpit."""

import dataclasses as dc

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.cockpit.cockpit_process import CockpitProcess
from remosplat_drake.cockpit.messages import MapPicture, PageContent
from remosplat_drake.cockpit.operator_input import SOURCE
from remosplat_drake.cockpit.worst_tick import WorstTick
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.motion_status import (
    HELD,
    MOVING,
    NOT_STARTED,
    MotionStatus,
)
from remosplat_drake.signals.optional_input import value_or_none
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.signals.supervisor_state import SupervisorState
from remosplat_drake.signals.target_state import FOLLOW, TargetState
from remosplat_drake.signals.thing import UNSEEN, UNSEEN_SPACE
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.object_view import at_present
from remosplat_drake.visualization.page_state import (
    supervised,
    unsupervised,
    without_map,
)

PUBLISH_PERIOD = 1 / 20
"""Time between two updates of the page [s]."""


class CockpitView(LeafSystem):
    """Sends the state of the run to the cockpit, twenty times a second.

    .. pydrake_system::

        name: CockpitView
        input_ports:
        - configuration
        - report
        - motion_status
        - target_state
        - supervision (optional)
        - map_status (optional)
        - outline (optional)
        - objects (optional)
        - scene_map (optional)

    `configuration` takes the measured q, `motion_status` the `MotionStatus`,
    `target_state` the `TargetState`, `supervision` the `SupervisorState`,
    `map_status` the `MapStatus` of a live map, `outline` the `TaskOutline` of
    an operator's jobs, `objects` the `SceneObject`s of these jobs, `scene_map`
    the `SceneMap` of a run without a live map, and `report` the controller's
    `TickReport`. The plots include the report of every tick.
    The view itself draws nothing, and does not wait for the cockpit.

    Args:
        process: The process that serves the cockpit's page.
        robot: The robot.
        initial: The map that the cockpit already shows.
        picture: The picture of this map.
        period: Time between two evaluations of the report, the control period
            [s].
    """

    def __init__(
        self,
        *,
        process: CockpitProcess,
        robot: RobotModel,
        initial: SceneMap | None,
        picture: MapPicture,
        period: float,
    ):
        super().__init__()
        self.set_name("cockpit_view")
        self._process = process
        self._robot = robot
        self._map = initial
        self._picture = picture
        self._worst: WorstTick | None = None
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        rest = np.eye(4)
        for name, value in (
            ("report", TickReport.before_first(robot.n_q, robot.n_u)),
            ("motion_status", NOT_STARTED),
            ("target_state", TargetState.at_rest(rest)),
            ("supervision", SupervisorState(np.zeros(robot.n_u))),
        ):
            self.DeclareAbstractInputPort(name, Value(value))
        for name in ("map_status", "outline", "objects", "scene_map"):
            self.DeclareAbstractInputPort(name, Value[object]())
        self.DeclarePeriodicPublishEvent(period, 0.0, self._sample)
        self.DeclarePeriodicPublishEvent(PUBLISH_PERIOD, 0.0, self._publish)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, inputs: dict[str, OutputPort], **arguments
    ) -> "CockpitView":
        """Adds a view to a diagram, and connects it.

        Args:
            builder: Builder of the diagram.
            inputs: Output ports, keyed by the name of the view's input port.
            **arguments: The arguments of `CockpitView`.
        """
        view = builder.AddSystem(CockpitView(**arguments))
        for name, port in inputs.items():
            builder.Connect(port, view.GetInputPort(name))
        return view

    def _input(self, context: Context, name: str):
        return value_or_none(self.GetInputPort(name), context)

    def _sample(self, context: Context):
        report = self._input(context, "report")
        if not np.isnan(report.time):
            self._worst = WorstTick.of(report).or_of(self._worst)

    def _publish(self, context: Context):
        q = self._configuration_input.Eval(context)
        status = self._input(context, "map_status")
        if status is not None and status.scene_map is not self._map:
            self._map = status.scene_map
            shown = self._picture.shows_unseen
            self._process.show_map(picture_of(self._map, shown))
        scene_map = self._input(context, "scene_map")
        if scene_map is not None and scene_map is not self._map:
            # The coverage, which contains the objects' space, stays the same.
            self._map = scene_map
            splat_W, field = scene_map.splat_W, scene_map.field
            picture = dc.replace(self._picture, field=field, splat_W=splat_W)
            self._process.show_map(picture)
        content = page_content(
            context.get_time(),
            q,
            self._robot,
            self._input(context, "motion_status"),
            self._input(context, "target_state"),
            self._input(context, "supervision"),
            status,
            self._worst,
        )
        outline = self._input(context, "outline")
        if outline is not None:
            payload = self._input(context, "report").payload
            objects = self._input(context, "objects")
            objects = at_present(objects, payload, self._robot, q)
            content = dc.replace(content, outline=outline, objects=objects)
        self._process.show(content)
        self._worst = None


def picture_of(scene_map: SceneMap, show_unseen: bool) -> MapPicture:
    """Returns the data of a map that the cockpit needs to draw it.

    Args:
        scene_map: The map.
        show_unseen: Whether the boundary of unseen space is visible at first.
    """
    return MapPicture(
        scene_map.field, scene_map.splat_W, scene_map.coverage, show_unseen
    )


def page_content(
    time: float,
    q: np.ndarray,
    robot: RobotModel,
    motion_status: MotionStatus,
    target: TargetState,
    supervision: SupervisorState | None,
    status: MapStatus | None,
    worst: WorstTick | None = None,
) -> PageContent:
    """Collects the cockpit's content at one moment.

    Args:
        time: Time of the diagram [s].
        q: The measured configuration, shape (n_q,).
        robot: The robot.
        motion_status: The robot's state.
        target: The target's state.
        supervision: The supervisor's state; None without a supervisor.
        status: Status of the live map in use; None without a live map.
        worst: Smallest clearance and longest duration of the control ticks
            since the previous update; None if unknown.
    """
    state = unsupervised(motion_status)
    if supervision is not None:
        # Only the client that operates the robot sees RELEASE.
        state = supervised(
            supervision, releases=True, motion_status=motion_status
        )
    if status is not None and status.scene_map.is_blank:
        state = without_map(state)
    cause = motion_status.cause if motion_status.kind in (HELD, MOVING) else ""
    if motion_status.kind == HELD and motion_status.thing == UNSEEN_SPACE.name:
        cause = UNSEEN  # Also where verification avoids it.
    robot_state = robot.state(np.array(q))
    does = target.text or target.mode
    if target.X_WTs is not None:
        does = f"{robot.effectors[target.effector]}: {does}"
    return PageContent(
        time=time,
        q=np.array(q),
        X_WE=robot_state.X_WEs[target.effector],
        X_WB=robot_state.X_WB,
        X_WT=target.X_WT,
        is_followed=target.mode == FOLLOW and target.command.source == SOURCE,
        state=state,
        held_link=motion_status.link if motion_status.is_obstructed else "",
        cause=cause,
        p_WHeld=motion_status.p_W if motion_status.is_obstructed else None,
        target=does,
        map=status.text if status is not None else "",
        trouble=status.trouble if status is not None else "",
        worst=worst,
        effector=target.effector,
        X_WTs=target.X_WTs,
    )
