"""Ticks find all that they need compiled."""

import numpy as np
import pytest
from numba_work import printed_number

from remosplat_drake.app.scenario import DEFAULT_SCENARIO, load_scenario
from remosplat_drake.app.warm_up import compile_kernels
from remosplat_drake.app.world import load_world
from remosplat_drake.oracle.unknown_space import UnknownSpaceField

# Runs a scenario, and prints how often its ticks made numba load or compile.
IN_TICKS = """
import sys
from numba_work import NumbaWork
from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.warm_up import compile_kernels
from remosplat_drake.app.world import load_world

scenario = load_scenario(sys.argv[1], sys.argv[2])
world = load_world(scenario)
compile_kernels(scenario, world)
application = build(scenario, world)
work = NumbaWork()
totals = []
run(application, on_progress=lambda *_: totals.append(work.total))
assert len(totals) > 50
print(totals[-1])
"""


def loads_in_ticks(text: str, **environment: str) -> int:
    """How often numba is at work while the default scenario runs."""
    return printed_number(IN_TICKS, DEFAULT_SCENARIO, text, **environment)


@pytest.mark.parametrize(
    "oracle",
    [
        "!SphereToEllipsoid {}",
        pytest.param("!DepthRasterization {}", marks=pytest.mark.slow),
        pytest.param(
            "!GroundTruth {rows: per_primitive}", marks=pytest.mark.slow
        ),
    ],
)
def test_no_tick_loads_a_kernel(oracle):
    """Past the things on the table, with look-ahead, as far as the target.

    A person comes by, unlike those that the kernels were compiled with.
    """
    assert loads_in_ticks(f"{{oracle: {oracle}, movers: {ADA}}}") == 0


ADA = """[{name: Ada, radius: 0.2, half_extents: [0, 0, 0.5], waypoints: [
  {time: 1, translation: [1, 2, 1]}, {time: 4, translation: [1, -2, 1]}]}]"""


# Prints how often numba loads or compiles with either solver: where the
# library's own is undecided, Clarabel is asked.
UNDECIDED = """
import sys
from numba_work import NumbaWork
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.warm_up import compile_kernels
from remosplat_drake.app.world import load_world
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.controller.program.solvers import ACTIVE_SET, CLARABEL
import numpy as np

scenario = load_scenario(sys.argv[1], sys.argv[2])
world = load_world(scenario)
compile_kernels(scenario, world)
law = ReactiveLaw.make(scenario.controller, world.robot, 0.01)
X_WT = world.robot.end_effector_pose(world.q0)
X_WT[:3, 3] += 0.1
u, work = np.zeros(world.robot.n_u), NumbaWork()
found = world.field.clearances(world.robot.spheres_at(world.q0), 0.5)
for solver in (ACTIVE_SET, CLARABEL):
    each = law.with_step(0.01, solver=solver)
    run_tick(each, 0.0, world.q0, X_WT, found, world.field, u)
print(work.total)
"""


@pytest.mark.parametrize(
    "solver",
    ["active_set", pytest.param("clarabel", marks=pytest.mark.slow)],
)
def test_whom_the_own_solver_asks_has_its_kernels_too(solver):
    text = f"{{controller: {{solver: {solver}}}}}"
    assert printed_number(UNDECIDED, DEFAULT_SCENARIO, text) == 0


@pytest.mark.slow
def test_no_tick_of_cameras_that_watch_loads_a_kernel():
    text = (
        "{movers_from: cameras, movers: [{waypoints: [{translation:"
        " [1.1, 0.9, 0.9]}]}], cameras: [{translation: [-0.2, 1.6, 1.7],"
        " look_at: [1.0, 0.2, 0.7]}]}"
    )
    assert loads_in_ticks(text) == 0


def test_a_live_map_has_its_kernels_too(monkeypatch):
    """Kernels for unseen space; its loop is another one."""
    scenario = load_scenario("StudioLive", "scene: {unknown: obstacle}")
    asked = []
    clearances = UnknownSpaceField.clearances

    def noting(self, spheres, max_distance=np.inf):
        asked.append(len(spheres))
        return clearances(self, spheres, max_distance)

    monkeypatch.setattr(UnknownSpaceField, "clearances", noting)
    world = load_world(scenario, blank=True)
    compile_kernels(scenario, world, live_map=True)
    assert asked


@pytest.mark.slow
def test_no_tick_of_the_very_first_run_compiles(tmp_path):
    assert loads_in_ticks("{}", NUMBA_CACHE_DIR=str(tmp_path)) == 0
