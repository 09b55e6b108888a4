"""What one control tick is made of, timed along a real run."""

from collections.abc import Callable, Iterator
from itertools import cycle, pairwise

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import World, load_world
from remosplat_drake.controller.decision import solve
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.reactive_program import Tick
from remosplat_drake.controller.solvers import ACTIVE_SET
from remosplat_drake.controller.tick import run_tick
from remosplat_drake.timing.measuring import Case

_EVERY = 4
"""Number of ticks of the run for each tick that is timed."""


def tick_cases(
    scenario_name: str | None = None, group: str = "tick"
) -> list[Case]:
    """Makes cases for the states that a scenario's run goes through.

    Args:
        scenario_name: Name of the scenario or its file; None for the default
            one.
        group: Prefix of the cases' names.
    """
    scenario = load_scenario(scenario_name)
    world = load_world(scenario)
    ticks = _recorded_ticks(scenario, world)
    laws = {}
    for name, verify in (("plain", False), ("verified", True)):
        config = load_scenario(scenario_name).controller
        config.verify = verify
        laws[name] = ReactiveLaw.make(
            config, world.robot, scenario.control_period
        )
    law = laws["verified"]
    laws["active set"] = law.with_step(law.dt, solver=ACTIVE_SET)
    programs = cycle([law.program(tick) for tick in ticks])
    reach = scenario.controller.collision.influence

    def whole_tick(law: ReactiveLaw) -> Callable[[Tick], object]:
        def body(tick: Tick) -> object:
            spheres = world.robot.spheres_at(tick.state.q)
            return run_tick(
                law,
                0.0,
                tick.state.q,
                tick.target,
                world.field.clearances(spheres, reach),
                world.field,
                tick.u_previous,
            )

        return body

    n = len(world.robot.spheres)
    return [
        Case(
            f"{group}: oracle query, {n} spheres",
            _over(
                ticks,
                lambda tick: world.field.clearances(tick.state.spheres, reach),
            ),
        ),
        Case(
            f"{group}: kinematics and all Jacobians",
            _over(ticks, lambda tick: world.robot.state(tick.state.q)),
        ),
        Case(
            f"{group}: program build",
            _over(ticks, law.program),
        ),
        Case(
            f"{group}: program solve",
            lambda: solve(next(programs), law.solver),
        ),
        Case(
            f"{group}: whole, no verification",
            _over(ticks, whole_tick(laws["plain"])),
        ),
        Case(f"{group}: whole, verified", _over(ticks, whole_tick(law))),
        Case(
            f"{group}: whole, verified, active set",
            _over(ticks, whole_tick(laws["active set"])),
        ),
    ]


def _over(
    ticks: list[Tick], body: Callable[[Tick], object]
) -> Callable[[], object]:
    states: Iterator[Tick] = cycle(ticks)
    return lambda: body(next(states))


def _recorded_ticks(scenario: Scenario, world: World) -> list[Tick]:
    """Returns the ticks of a headless run, as the controller saw them."""
    application = build(scenario, world)
    run(application)
    ticks = []
    reports = application.recorder.reports
    for before, report in pairwise(reports):
        state = world.robot.state(report.q)
        ticks.append(
            Tick(
                world.robot,
                state,
                report.target,
                report.target.error(state.X_WE),
                report.clearances,
                before.command,
                scenario.control_period,
            )
        )
    return ticks[::_EVERY]
