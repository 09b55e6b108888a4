"""The control law as a Drake system: one program a period, nothing copied."""

import copy

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import (
    DiagramBuilder,
    EventStatus,
    LeafSystem,
)
from pydrake.systems.primitives import ConstantValueSource, Integrator

from remosplat_drake.controller import reactive_controller
from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals import tick_report

PERIOD = 0.02


class CountingField(SignedDistanceField):
    """Counts queries, and copies of itself."""

    queries = 0
    copies = 0

    def clearances(self, spheres, max_distance=np.inf):
        self.queries += 1
        return super().clearances(spheres, max_distance)

    def __deepcopy__(self, memo):
        self.copies += 1
        return super().__deepcopy__(memo)

    def __copy__(self):
        raise AssertionError("a shallow copy is not needed")


class Watcher(LeafSystem):
    """Reads the report far more often than there are ticks."""

    def __init__(self, prototype):
        super().__init__()
        self.reports = []
        self.report_input = self.DeclareAbstractInputPort(
            "report", Value(prototype)
        )
        self.DeclarePeriodicPublishEvent(0.001, 0.0, self._watch)

    def _watch(self, context):
        report = self.report_input.Eval(context)
        if not self.reports or self.reports[-1] is not report:
            self.reports.append(report)


class Loop:
    """The three-link arm over a slab, integrated at 1 kHz."""

    def __init__(self, robot):
        slab = Box(RigidTransform([0.9, 0, 0.5]), np.array([0.5, 0.5, 0.1]))
        self.field = CountingField(PrimitiveScene(boxes=(slab,)))
        config = gain_set("tuned")
        config.verify = False
        law = ReactiveLaw.make(config, robot, PERIOD)
        target = RigidTransform(
            robot.end_effector_pose(np.array([0.3, 0.3, 0.1]))
        )
        builder = DiagramBuilder()
        arm = builder.AddSystem(Integrator(robot.n_u))
        self.oracle = DistanceOracle.AddToBuilder(
            builder,
            robot=robot,
            field=self.field,
            max_distance=config.collision.influence,
            configuration=arm.get_output_port(),
        )
        self.controller = ReactiveController.AddToBuilder(
            builder, law=law, oracle=self.oracle
        )
        source = builder.AddSystem(ConstantValueSource(Value(target)))
        report = self.controller.GetOutputPort("report")
        builder.Connect(
            arm.get_output_port(),
            self.controller.GetInputPort("configuration"),
        )
        builder.Connect(
            source.get_output_port(), self.controller.GetInputPort("target")
        )
        builder.Connect(
            self.controller.GetOutputPort("velocity_commanded"),
            arm.get_input_port(),
        )
        self.watcher = builder.AddSystem(
            Watcher(tick_report.TickReport.before_first(robot.n_q, robot.n_u))
        )
        builder.Connect(report, self.watcher.report_input)
        self.simulator = Simulator(builder.Build())
        integrator = self.simulator.get_mutable_integrator()
        integrator.set_maximum_step_size(1e-3)
        integrator.set_fixed_step_mode(True)
        arm.set_integral_value(
            arm.GetMyMutableContextFromRoot(
                self.simulator.get_mutable_context()
            ),
            np.zeros(robot.n_u),
        )

    def own_context(self, system):
        return system.GetMyContextFromRoot(self.simulator.get_context())


@pytest.fixture
def loop(three_link) -> Loop:
    return Loop(three_link)


@pytest.fixture
def ticks(monkeypatch) -> list[float]:
    """Times at which the law was run."""
    times = []

    def counted(law, time, *arguments, **options):
        times.append(time)
        return run_tick(law, time, *arguments, **options)

    run_tick = reactive_controller.run_tick
    monkeypatch.setattr(reactive_controller, "run_tick", counted)
    return times


def test_one_program_a_period_however_fast_the_plant(loop, ticks):
    loop.simulator.AdvanceTo(0.2)
    np.testing.assert_allclose(ticks, PERIOD * np.arange(10), atol=1e-12)


def test_the_oracle_is_asked_once_a_tick_for_all_readers(loop, ticks):
    loop.simulator.AdvanceTo(0.2)
    assert loop.field.queries == len(ticks)


def test_a_tick_copies_no_map(loop):
    loop.simulator.AdvanceTo(0.1)
    copies = loop.field.copies
    loop.simulator.AdvanceTo(0.3)
    # Drake may ask for copies, each of which is the object itself.
    assert copy.deepcopy(loop.field) is loop.field
    context = loop.own_context(loop.controller)
    port = loop.controller.GetInputPort("distance_field")
    assert port.Eval(context) is loop.field
    assert loop.field.copies - copies <= 2


def test_clearances_and_reports_keep_their_identity(loop):
    loop.simulator.AdvanceTo(0.1)
    # The latest tick was at 0.08 s; the watcher has seen each report once.
    times = [report.time for report in loop.watcher.reports[1:]]
    np.testing.assert_allclose(times, PERIOD * np.arange(5), atol=1e-12)
    report = loop.controller.GetOutputPort("report").Eval(
        loop.own_context(loop.controller)
    )
    assert report is loop.watcher.reports[-1]
    assert copy.deepcopy(report) is report
    clearances = loop.oracle.GetOutputPort("clearances")
    context = loop.own_context(loop.oracle)
    assert clearances.Eval(context) is clearances.Eval(context)


def test_the_command_is_held_between_ticks(loop, three_link):
    commands = []

    def monitor(root):
        context = loop.controller.GetMyContextFromRoot(root)
        port = loop.controller.GetOutputPort("velocity_commanded")
        commands.append(port.Eval(context))
        return EventStatus.DidNothing()

    loop.simulator.set_monitor(monitor)
    loop.simulator.AdvanceTo(0.1)
    distinct = np.unique(np.array(commands), axis=0)
    assert len(commands) >= 100
    # Before the first tick, and the commands of five ticks.
    assert len(distinct) <= 6
    np.testing.assert_array_equal(commands[0], np.zeros(three_link.n_u))


def test_the_report_is_exported_with_the_times_of_its_phases(loop):
    loop.simulator.AdvanceTo(0.1)
    report = loop.watcher.reports[-1]
    assert report.status == tick_report.OPTIMAL
    phases = {"guidance", "oracle", "solve", "tick"}
    assert set(report.timings) == {*phases, "total"}
    assert all(seconds >= 0 for seconds in report.timings.values())
    parts = sum(v for k, v in report.timings.items() if k != "total")
    assert parts <= report.timings["total"]
    np.testing.assert_array_equal(
        report.command,
        loop.controller.GetOutputPort("velocity_commanded").Eval(
            loop.own_context(loop.controller)
        ),
    )


def test_recorded_configurations_do_not_change_afterwards(loop):
    loop.simulator.AdvanceTo(0.2)
    q = np.array([report.q for report in loop.watcher.reports[1:]])
    assert len(np.unique(q, axis=0)) == len(q)


def test_a_lost_configuration_brakes_and_is_survived(loop, three_link):
    loop.simulator.AdvanceTo(0.1)
    root = loop.simulator.get_mutable_context()
    root.SetContinuousState(np.full(three_link.n_q, np.nan))
    loop.simulator.AdvanceTo(0.11)
    report = loop.watcher.reports[-1]
    assert report.status == tick_report.BRAKING
    assert report.reason == "measured configuration is not finite"
    root.SetContinuousState(np.zeros(three_link.n_q))
    loop.simulator.AdvanceTo(0.13)
    assert loop.watcher.reports[-1].status == tick_report.OPTIMAL
