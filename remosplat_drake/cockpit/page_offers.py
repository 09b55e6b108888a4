"""`PageOffers`: offers alternative targets on a simulated run's page."""

from collections.abc import Callable
from functools import partial
from threading import Lock, Thread
from time import sleep

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import Context, LeafSystem

from remosplat_drake.cockpit.offers import (
    LABELS,
    LOOK_THERE,
    Offer,
    OfferSearch,
    Trouble,
    trouble_of,
)
from remosplat_drake.cockpit.reach import is_within_reach
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.motion_status import NOT_STARTED
from remosplat_drake.signals.target import Target
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_style import button, heading

INSTEAD = heading("Try instead")
"""Name of the heading above the buttons."""

BUTTONS = {label: button(label) for label in LABELS if label != LOOK_THERE}
"""Names of the buttons, keyed by the offer's label. LOOK_THERE has no button,
since a run with given targets takes no camera frames."""

_PERIOD = 0.1
"""Time between two checks of the robot's state [s]."""

_PAUSE = 0.02
"""Time after which the thread checks again whether the next test is due [s]."""

Works = Callable[[np.ndarray], bool]
"""Function that returns whether the robot can reach a target."""


class OfferThread:
    """Searches for alternative targets in a thread beside the control loop.

    Attributes:
        offers: The offers so far.
    """

    def __init__(self):
        self._search, self._lock = OfferSearch(), Lock()
        self._works: Works = lambda X_WT: False
        self._thread: Thread | None = None

    @property
    def offers(self) -> tuple[Offer, ...]:
        """The offers so far for the latest situation."""
        return self._search.offers

    def ask(self, trouble: Trouble | None, field: object, works: Works) -> None:
        """Starts a new search if the situation or the map has changed.

        Args:
            trouble: The situation; None if no offer is needed.
            field: The map.
            works: Function that returns whether the robot can reach a target.
        """
        with self._lock:
            self._works = works
            self._search.begin(trouble, field)
            if self._search.is_busy and self._thread is None:
                self._thread = Thread(target=self._run, daemon=True)
                self._thread.start()

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._search.is_busy:
                    self._thread = None
                    return
                test = self._search.next_test()
            if test is None:
                sleep(_PAUSE)
                continue
            works = self._works(test.X_WT)
            with self._lock:
                self._search.judge(test, works)


class PageOffers(LeafSystem):
    """Offers alternative targets while an obstacle or a limit holds the robot.

    .. pydrake_system::

        name: PageOffers
        input_ports:
        - configuration
        - report
        - motion_status
        - distance_field
        output_ports:
        - instead

    `configuration` takes the measured q, `report` the `TickReport`,
    `motion_status` the `MotionStatus` and `distance_field` the map. `instead`
    outputs the `Target`s whose buttons were pressed, in the order of the
    presses. A thread tests targets, so the control loop does not wait. The
    system is only for simulated robots with one end effector, since visitors of
    a real robot's page must not move the robot.

    Args:
        page: The page that gets the buttons.
        robot: The robot.
        planner: Finds configurations and paths.
        stopping: Distance that the robot keeps from the scene [m].
    """

    def __init__(
        self,
        *,
        page: MeshcatPage,
        robot: RobotModel,
        planner: MotionPlanner,
        stopping: float,
    ):
        super().__init__()
        self.set_name("page_offers")
        self._meshcat, self._robot = page.meshcat, robot
        self._reaches = partial(is_within_reach, planner)
        self._stopping = stopping
        self._thread = OfferThread()
        self._shown: tuple[Offer, ...] = ()
        self._accepted: tuple[Target, ...] = ()
        self._replaced: Target | None = None
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._report_input = self.DeclareAbstractInputPort(
            "report", Value(TickReport.before_first(robot.n_q, robot.n_u))
        )
        self._motion_status_input = self.DeclareAbstractInputPort(
            "motion_status", Value(NOT_STARTED)
        )
        self._field_input = self.DeclareAbstractInputPort(
            "distance_field", Value[object]()
        )
        self.DeclareAbstractOutputPort(
            "instead",
            Value[object](()).Clone,
            self._calc_instead,
            {self.time_ticket()},
        )
        self.DeclarePeriodicPublishEvent(_PERIOD, 0.0, self._publish)

    def _calc_instead(self, context: Context, output: Value):
        output.set_value(self._accepted)

    def _publish(self, context: Context):
        q = np.array(self._configuration_input.Eval(context))
        report = self._report_input.Eval(context)
        field = self._field_input.Eval(context)
        motion_status = self._motion_status_input.Eval(context)
        self._accept(report.target)
        trouble = None
        if not self._is_replaced(report.target):
            trouble = trouble_of(motion_status, report.target, self._robot, q)
        self._thread.ask(trouble, field, self._test(field, q, report.target))
        self._show(self._thread.offers if trouble is not None else ())

    def _test(
        self, field: DistanceField, q: np.ndarray, target: Target
    ) -> Works:
        """Returns the test of a target."""

        def works(X_WT: np.ndarray) -> bool:
            aim = target.at(X_WT)
            return self._reaches(field, self._stopping, q, aim)

        return works

    def _accept(self, target: Target) -> None:
        """Accepts the offer whose button was pressed."""
        for offer in self._shown:
            if self._meshcat.GetButtonClicks(BUTTONS[offer.label]):
                self._accepted += (target.at(offer.X_WT),)
                self._replaced = target
                self._show(())
                return

    def _is_replaced(self, target: Target) -> bool:
        """Whether the robot still has the target that an offer replaces."""
        if self._replaced is not None and not np.array_equal(
            target.X_WT, self._replaced.X_WT
        ):
            self._replaced = None
        return self._replaced is not None

    def _show(self, offers: tuple[Offer, ...]) -> None:
        """Shows a button for each offer."""
        offers = tuple(offer for offer in offers if offer.label in BUTTONS)
        if offers == self._shown:
            return
        names = [BUTTONS[offer.label] for offer in offers]
        before = [BUTTONS[offer.label] for offer in self._shown]
        for name in before:
            if name not in names:
                self._meshcat.DeleteButton(name)
        if before and not offers:
            self._meshcat.DeleteButton(INSTEAD)
        if offers and not before:
            self._meshcat.AddButton(INSTEAD)
        for name in names:
            if name not in before:
                self._meshcat.AddButton(name)
        self._shown = offers
