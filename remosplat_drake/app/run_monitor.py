"""`RunMonitor`: examines each step of a run, and ends the run."""

import math
import re
from collections import deque
from collections.abc import Callable

from pydrake.systems.framework import Context, EventStatus

from remosplat_drake.app.diagram import Application
from remosplat_drake.app.run_readings import (
    map_status_of,
    motion_status_of,
    selection_of,
    supervision_of,
)
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.motion_status import NOT_STARTED, MotionStatus
from remosplat_drake.signals.supervisor_state import (
    STOPPED,
    UNARMED,
    SupervisorState,
)
from remosplat_drake.signals.tick_report import TickReport

ProgressCallback = Callable[[float, MotionStatus, TickReport | None], None]
"""Function that is called with the time [s], the state and the last report."""

SupervisionCallback = Callable[[SupervisorState], None]
"""Function that is called with the supervisor's state."""

MotionStatusCallback = Callable[[float, MotionStatus], None]
"""Function that is called with the time [s] and the robot's state."""

MapCallback = Callable[[MapStatus], None]
"""Function that is called with the live map's state."""

KEPT_STATUSES = 2000
"""A run keeps at most this many changes of the robot's state in memory. The
number is bounded, since a run may last for hours."""

_NUMBER = re.compile(r"\d+(\.\d+)?")
"""Pattern of the numbers in a message. Two messages that differ only in numbers
report the same problem."""


class RunMonitor:
    """Drake's monitor of a run: examines each step and ends the run.

    Attributes:
        is_finished: Whether the run is over.
    """

    def __init__(
        self,
        application: Application,
        *,
        start: float = 0.0,
        on_progress: ProgressCallback | None = None,
        on_supervision: SupervisionCallback | None = None,
        on_motion_status: MotionStatusCallback | None = None,
        on_map: MapCallback | None = None,
        until: Callable[[PoseError], bool] | None = None,
        patience: float = 0.0,
        progress_period: float = 0.0,
    ):
        """Makes the monitor of a run.

        Args:
            application: The diagram that runs, with all of its parts.
            start: Time of the context at which the run starts [s].
            on_progress: Function that is called with the time since the start
                [s], the robot's state and the latest tick report.
            on_supervision: Function that is called with the supervisor's state
                whenever its mode has changed, or a release was refused.
            on_motion_status: Function that is called with the time since the
                start [s] and the robot's state whenever the state has changed.
            on_map: Function that is called with the live map's status whenever
                the field `news` of this status changes.
            until: Function that decides whether the run ends; without it, the
                run ends when the robot arrives at the last target. It is called
                once per step with the error to the present target, and returns
                True if the run ends.
            patience: Time for which a stopped robot waits until a person
                releases it [s]; then the run ends.
            progress_period: At least this much time passes between two calls of
                `on_progress` [s].
        """
        self._application = application
        self._on_progress = on_progress
        self._on_supervision = on_supervision
        self._on_motion_status = on_motion_status
        self._on_map = on_map
        self._map_news = ""
        self._motion_history: deque[tuple[float, MotionStatus]] = deque(
            maxlen=KEPT_STATUSES
        )
        self._until = until
        self._patience = patience
        self._progress_period = progress_period
        self._progressed = -math.inf
        self._start = start
        self._time = start
        self._told = "", ""
        self._waited = 0.0
        self._paused = 0.0
        self.is_finished = False

    @property
    def motion_history(self) -> tuple[tuple[float, MotionStatus], ...]:
        """The latest changes of the robot's state, with times [s]."""
        return tuple(self._motion_history)

    @property
    def time_limit(self) -> float:
        """Time of the context at which the run fails [s].

        Time during which the robot is stopped does not count.
        """
        limit = self._application.scenario.time_limit
        return self._start + limit + self._paused

    def __call__(self, root: Context) -> EventStatus:
        """Examines the diagram after a step; Drake's simulator calls it.

        Args:
            root: Context of the whole diagram.

        Returns:
            The status, which ends the simulation once the run is over.
        """
        targets = self._application.targets
        context = targets.GetMyContextFromRoot(root)
        time = root.get_time() - self._start
        is_due = not 0 <= time - self._progressed < self._progress_period
        if self._on_progress is not None and is_due:
            self._progressed = time
            self._on_progress(
                time,
                motion_status_of(self._application, root),
                self._application.recorder.latest,
            )
        supervision = supervision_of(self._application, root)
        if supervision is not None:
            self._watch(root.get_time(), supervision)
        if supervision is not None and supervision.is_latched:
            stands = supervision.mode == STOPPED
            stands = stands and supervision.reason != UNARMED
            self.is_finished = stands and self._waited >= self._patience
        elif self._until is None:
            progress = targets.progress(context)
            self.is_finished = progress.finished or bool(progress.failed)
        else:
            self.is_finished = self._until(targets.error(context))
        self._listen(time, root)
        self._report_map(root)
        self._report_guidance(root)
        if self.is_finished:
            return EventStatus.ReachedTermination(
                self._application.diagram, "the run is over"
            )
        return EventStatus.DidNothing()

    def _listen(self, time: float, root: Context) -> None:
        """Stores and reports changes of the robot's state."""
        motion_status = motion_status_of(self._application, root)
        known = self._motion_history
        before = known[-1][1] if known else NOT_STARTED
        if not motion_status.is_news_after(before):
            return
        known.append((time, motion_status))
        if self._on_motion_status is not None:
            self._on_motion_status(time, motion_status)

    def _report_map(self, root: Context) -> None:
        """Reports changes of the live map."""
        status = map_status_of(self._application, root)
        if status is None or self._on_map is None:
            return
        news = status.news
        if status.trouble:
            # Numbers in the text, such as a clearance, change at every tick.
            news = _NUMBER.sub("#", news)
        before, self._map_news = self._map_news, news or self._map_news
        if self._map_news != before:
            self._on_map(status)

    def _report_guidance(self, root: Context) -> None:
        """Ends the run if guidance has given up and `give_up` is set."""
        selection = selection_of(self._application, root)
        if selection is None:
            return
        planning = self._application.scenario.controller.guidance.planning
        if planning.give_up and selection.has_given_up(planning.attempts):
            self.is_finished = True

    def _watch(self, time: float, supervision: SupervisorState) -> None:
        """Measures how long the robot is stopped; reports changes."""
        step, self._time = time - self._time, time
        stands = supervision.mode == STOPPED
        # No person has released the robot yet.
        unarmed = stands and supervision.reason == UNARMED
        waits = stands and not unarmed
        self._waited = self._waited + step if waits else 0.0
        patient = waits and self._patience > 0
        self._paused += step if patient or unarmed else 0.0
        if (supervision.mode, supervision.refusal) != self._told:
            self._told = supervision.mode, supervision.refusal
            if self._on_supervision is not None:
                self._on_supervision(supervision)
