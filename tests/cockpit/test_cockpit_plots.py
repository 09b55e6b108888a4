"""Plots of the cockpit: the worst of every tick, at a low rate."""

import dataclasses as dc

import numpy as np
import pytest

pytest.importorskip("viser")

from browser import find_chromium
from cockpit_tab import CockpitTab, open_cockpit
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from remosplat_drake.cockpit.cockpit_plots import with_room_for
from remosplat_drake.cockpit.cockpit_process import CockpitProcess
from remosplat_drake.cockpit.cockpit_view import CockpitView
from remosplat_drake.cockpit.messages import MapPicture, PageContent
from remosplat_drake.cockpit.worst_tick import WorstTick
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.motion_status import NOT_STARTED
from remosplat_drake.signals.target_state import TargetState
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.svg_plot import SvgPlot

TITLES = "Smallest clearance", "Distance to the target", "A control tick takes"


def report_of(robot: RobotModel, distance: float, duration: float):
    """A tick that saw something so near, and took so long."""
    clearances = Clearances(
        np.array([0]), np.array([distance]), np.eye(3)[:1], np.zeros((1, 3))
    )
    before = TickReport.before_first(robot.n_q, robot.n_u)
    timings = {"total": duration}
    return dc.replace(before, time=0.0, clearances=clearances, timings=timings)


def test_of_several_ticks_the_worst_counts():
    near, slow = WorstTick(0.01, 0.003), WorstTick(np.inf, 0.02)
    assert near.or_of(slow) == slow.or_of(near) == WorstTick(0.01, 0.02)
    assert near.or_of(None) is near
    # Ticks without a time do not count in the others.
    assert near.or_of(WorstTick(0.5, np.nan)) == near


def test_what_was_never_shown_is_told_with_the_next_moment():
    eye = np.eye(4)
    looks = [
        PageContent(0.05 * k, np.zeros(9), eye, eye, eye, worst=worst)
        for k, worst in enumerate([WorstTick(0.01, 0.003), None])
    ]
    assert looks[1].after(looks[0]).worst == WorstTick(0.01, 0.003)
    assert looks[1].after(looks[0]).time == 0.05
    assert looks[0].after(None) is looks[0]
    assert looks[0].after(looks[1]) is looks[0]


def test_every_tick_counts_although_few_moments_are_shown():
    """The process has no listener yet: it keeps what it is told."""
    robot = load_robot("frankie")
    process = CockpitProcess(lambda code: None)
    view = CockpitView(
        process=process,
        robot=robot,
        initial=None,
        picture=MapPicture(
            SignedDistanceField(PrimitiveScene()), None, None, False
        ),
        period=0.01,
    )
    simulator = Simulator(view)
    context = simulator.get_mutable_context()
    for name, value in (
        ("configuration", robot.q_home),
        ("motion_status", Value(NOT_STARTED)),
        ("target_state", Value(TargetState.at_rest(np.eye(4)))),
    ):
        view.GetInputPort(name).FixValue(context, value)
    before = TickReport.before_first(robot.n_q, robot.n_u)
    for time, report in (
        (0.005, before),
        (0.015, report_of(robot, 0.5, 0.002)),
        (0.025, report_of(robot, 0.03, 0.002)),
        (0.035, report_of(robot, 0.5, 0.009)),
        (0.12, report_of(robot, 0.4, 0.002)),
    ):
        view.GetInputPort("report").FixValue(context, Value(report))
        simulator.AdvanceTo(time)
    assert process._content is not None
    assert process._content.time == pytest.approx(0.1)
    assert process._content.worst == WorstTick(0.03, 0.009)


@pytest.mark.parametrize(
    ("values", "upper"),
    [
        ([], 0.1),
        ([0.05, np.nan, np.inf], 0.1),
        ([0.11], 0.2),
        ([0.2], 0.2),
        ([0.21, 0.1], 0.5),
        ([7.0], 10.0),
    ],
)
def test_the_axis_has_room_for_all_values(values, upper):
    plot = with_room_for(SvgPlot("a", "m", 0.0, 0.1), np.array(values))
    assert plot.upper == pytest.approx(upper)


def shown_plots(tab: CockpitTab) -> list[str]:
    """What the plots in sight say."""
    svgs = "[...document.querySelectorAll('.remosplat-plot svg')]"
    sight = f"{svgs}.filter(s => s.getBoundingClientRect().height > 50)"
    return tab.tab.evaluate(f"{sight}.map(s => s.textContent)")


@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
@pytest.mark.slow
def test_a_watcher_unfolds_the_plots_and_keeps_stop_in_sight(rig):
    with open_cockpit(rig.url) as watcher:
        assert shown_plots(watcher) == []
        watcher.unfold("Plots")
        rig.until(lambda: len(shown_plots(watcher)) == len(TITLES))
        X_WT = rig.content.X_WE.copy()
        X_WT[0, 3] += 0.25

        def live() -> bool:
            """A moment later, until it has been drawn."""
            rig.show(
                time=rig.content.time + 0.05,
                X_WT=X_WT,
                worst=WorstTick(0.034, 0.0123),
            )
            said = shown_plots(watcher)
            assert all(t in s for t, s in zip(TITLES, said, strict=True))
            values = "0.034 m", "0.250 m", "12.3 ms"
            return all(v in s for v, s in zip(values, said, strict=True))

        rig.until(live)
        for size in ((390, 844), (844, 390), (1280, 800)):
            watcher.tab.show_as(*size, mobile=size[0] < 1000)
            watcher.wait_for_stop_in_sight(size)
            watcher.scroll_to_the_end()
            watcher.wait_for_stop_in_sight(size)
        assert watcher.errors == []
