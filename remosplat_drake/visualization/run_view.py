"""`RunView`: draws the controller's inputs and decisions on the page."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import (
    Context,
    Diagram,
    DiagramBuilder,
    LeafSystem,
)

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.clearance_lines import ClearanceLines
from remosplat_drake.visualization.growing_path import GrowingPath
from remosplat_drake.visualization.hand_ghost import HandGhost
from remosplat_drake.visualization.legend import BASE_PATH, legend
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.robot_view import PUBLISH_PERIOD
from remosplat_drake.visualization.scene_look import ROOT
from remosplat_drake.visualization.sphere_view import SphereView
from remosplat_drake.visualization.target_view import TargetView
from remosplat_drake.visualization.trace_colors import rgba, trace_colors

TARGET = f"{ROOT}/target"
PATHS = f"{ROOT}/paths"
HAND_TRACE = f"{PATHS}/end_effector"
GHOST = f"{ROOT}/ghost"

_NAME = "run_view"
_TRACE_HEIGHT = 0.012  # The base's trace lies on the floor, not in it [m].


class RunView(LeafSystem):
    """Draws targets, clearances and traces.

    .. pydrake_system::

        name: RunView
        input_ports:
        - configuration
        - report

    `configuration` takes the measured q, and `report` the controller's
    `TickReport`. The view does not query an oracle, so it does not delay the
    controller. While the hand is away from the target, a translucent hand
    (ghost) is drawn at the target. Red lines connect sphere surfaces with their
    closest scene points; lines of active constraints are thick, all other lines
    are pale. The end effector's trace is yellow, and the base's trace is blue;
    the view clears both traces when time runs backwards. If there are several
    end effectors, each has its own colour, which the legend states.

    Args:
        page: The page to draw on.
        robot: The robot that moves.
    """

    def __init__(self, *, page: MeshcatPage, robot: RobotModel):
        LeafSystem.__init__(self)
        self._page = page
        self._robot = robot
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._report_input = self.DeclareAbstractInputPort(
            "report",
            AbstractValue.Make(TickReport.before_first(robot.n_q, robot.n_u)),
        )
        self._spheres = SphereView(page, robot)
        self._lines = ClearanceLines(page, robot)
        colors = trace_colors(robot.effectors)
        self._hand_traces = [
            GrowingPath(page, _named(HAND_TRACE, name), rgba(color))
            for name, color in colors.items()
        ]
        page.set_legend(legend(robot.effectors))
        self._base_trace = GrowingPath(page, f"{PATHS}/base", BASE_PATH)
        self._report: TickReport | None = None
        self._time = -np.inf
        self._p_WT: np.ndarray | None = None
        self._targets = [
            TargetView(page, _named(TARGET, name)) for name in robot.effectors
        ]
        self._ghosts = [
            HandGhost(page, _named(GHOST, name), robot, i)
            for i, name in enumerate(robot.effectors)
        ]
        self._X_WEs: np.ndarray | None = None
        self.DeclarePeriodicPublishEvent(PUBLISH_PERIOD, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, page: MeshcatPage, robot: RobotModel
    ) -> "RunView":
        """Adds a view to a diagram; the caller connects its two ports."""
        return builder.AddNamedSystem(_NAME, RunView(page=page, robot=robot))

    def _publish(self, context: Context):
        self._page.beat()
        time = context.get_time()
        q = self._configuration_input.Eval(context)
        report = self._report_input.Eval(context)
        self._draw_motion(q, time)
        if report is not self._report:
            self._report = report
            self._draw_report(report, time)
        self._spheres.update(q, report, time)

    def draw_targets(self, aim: Aim, time: float):
        """Draws the targets of the end effectors.

        Args:
            aim: The targets.
            time: Time in a recording [s].
        """
        for effector, target in aim.items:
            self._targets[effector].update(target, time)
            X_WE = None if self._X_WEs is None else self._X_WEs[effector]
            self._ghosts[effector].update(target, X_WE, time)
            if effector == 0 and target.is_known:
                self._p_WT = target.X_WT[:3, 3]

    def _draw_motion(self, q: np.ndarray, time: float):
        if time < self._time:
            for trace in self._hand_traces:
                trace.clear()
            self._base_trace.clear()
        self._time = time
        self._X_WEs = X_WEs = self._robot.end_effector_poses(q)
        for trace, X_WE in zip(self._hand_traces, X_WEs, strict=True):
            trace.append(X_WE[:3, 3], time)
        base = self._robot.state(np.array(q)).X_WB[:3, 3]
        self._page.set_places(X_WEs[0][:3, 3], base, self._p_WT)
        if self._robot.n_base:
            self._base_trace.append(np.array([*q[:2], _TRACE_HEIGHT]), time)

    def _draw_report(self, report: TickReport, time: float):
        self._lines.draw(report, time)
        status = report.status.replace("_", " ")
        self._page.set_status(status)
        self.draw_targets(report.aim, time)


def draw_targets(diagram: Diagram, aim: Aim) -> None:
    """Draws the targets before a run begins.

    Args:
        diagram: A diagram with a `RunView`.
        aim: The targets.
    """
    diagram.GetSubsystemByName(_NAME).draw_targets(aim, 0.0)


def _named(path: str, effector: str) -> str:
    """Returns the scene-tree path of an object that belongs to an effector."""
    return f"{path}_{effector}" if effector else path
