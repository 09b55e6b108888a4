"""Two robots in one simulation: the one with the right of way goes first."""

from itertools import product

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from remosplat_drake.app.diagram import build
from remosplat_drake.app.other_robot_config import OtherRobot
from remosplat_drake.app.other_robots import DrivenRobot
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.recording.mover_contacts import distances
from remosplat_drake.scene.kernels.mover_reach import reach
from remosplat_drake.scene.mover import Movers
from remosplat_drake.station.robot_movers import RobotMovers

CORNERS = np.array(list(product([-1.0, 1.0], repeat=3)))

# Cheap ones: the true scene, without looking ahead.
CHEAP = "oracle: !GroundTruth {}, controller: {guidance: {enabled: false}}"


def load(folder, right_of_way: str) -> Scenario:
    shipped = load_scenario("TwoRobots")
    truth = shipped.scene.truth
    target = "{translation: [1.0, 0.0, 0.9], rpy_deg: [180, 0, 0]}"
    away = "{translation: [0.8, -0.9, 0.9], rpy_deg: [180, 0, 0]}"
    (folder / "two.yaml").write_text(
        f"First: {{scene: {{truth: '{truth}'}}, {CHEAP},\n"
        "  control_period: 0.02, robot: {base_pose: [0, 0.8, 0]},\n"
        f"  targets: [{target}], movers: [!OtherRobot {{name: Bert,\n"
        f"  scenario: 'two.yaml:Bert', right_of_way: {right_of_way}}}]}}\n"
        f"Bert: {{scene: {{truth: '{truth}'}}, {CHEAP},\n"
        "  robot: {base_pose: [0, -0.8, 0]},\n"
        f"  targets: [{target}, {away}]}}\n"
    )
    return load_scenario(str(folder / "two.yaml") + ":First")


class Both:
    """Two robots, looked at from outside."""

    def __init__(self, scenario: Scenario):
        self.app = build(scenario, load_world(scenario))
        self.simulator = Simulator(self.app.diagram)
        (self.other,) = (
            s
            for s in self.app.diagram.GetSystems()
            if isinstance(s, DrivenRobot)
        )

    def context(self, system):
        return system.GetMyContextFromRoot(self.simulator.get_context())

    def progress(self) -> tuple[int, int]:
        ours, theirs = (
            targets.progress(self.context(targets)).index
            for targets in (self.app.targets, self.other.loop.targets)
        )
        return ours, theirs

    def distance(self) -> float:
        """From our spheres to the other one's links."""
        port = self.app.movers
        assert port is not None
        movers: Movers = port.Eval(self.context(port.get_system()))
        q = self.app.configuration
        spheres = self.app.world.robot.spheres_at(
            q.Eval(self.context(q.get_system()))
        )
        gap, _ = distances(
            movers.at(movers.stamp), spheres.p_WS, spheres.radius
        )
        return float(gap.min())

    def movers(self) -> list[Movers]:
        """What each is to the other."""
        ports = [
            system.get_output_port()
            for system in self.app.diagram.GetSystems()
            if isinstance(system, RobotMovers)
        ] + [self.other.GetOutputPort("movers")]
        return [p.Eval(self.context(p.get_system())) for p in ports]

    def run(self, limit: float) -> tuple[list[tuple[int, int]], float]:
        """Progresses that occur, and the least distance."""
        seen, least = [], np.inf
        for time in np.arange(0.1, limit, 0.1):
            self.simulator.AdvanceTo(time)
            least = min(least, self.distance())
            if not seen or seen[-1] != self.progress():
                seen.append(self.progress())
            if seen[-1] == (1, 2):
                break
        return seen, least


@pytest.mark.slow
def test_the_one_that_yields_comes_second(tmp_path):
    seen, least = Both(load(tmp_path, "theirs")).run(40.0)
    assert seen[0] == (0, 0) and seen[-1][0] == 1
    # The other one was there before us.
    assert all(theirs >= 1 for ours, theirs in seen if ours)
    assert least > 0.02


@pytest.mark.slow
def test_without_a_right_of_way_they_keep_apart(tmp_path):
    """Whether one finds a way round the other or both wait is not promised."""
    _, least = Both(load(tmp_path, "nobodys")).run(20.0)
    assert least > 0.02


@pytest.mark.slow
@pytest.mark.parametrize("right_of_way", ["ours", "theirs"])
def test_they_keep_the_bounds_that_the_other_is_told(tmp_path, right_of_way):
    both = Both(load(tmp_path, right_of_way))
    told = []
    for time in np.arange(1, 600) * 0.02:
        both.simulator.AdvanceTo(time)
        told.append(both.movers())
    outside = [
        beyond(was, now)
        for ahead in (1, 2, 3, 5, 10, 25)
        for before, after in zip(told[::3], told[ahead::3], strict=False)
        for was, now in zip(before, after, strict=True)
    ]
    assert len(outside) > 2000 and max(outside) <= 0.0


def beyond(was: Movers, now: Movers) -> float:
    """How far corners are from where they may be by what was told [m]."""
    time, far = now.stamp - was.stamp, []
    arrays = was.at(now.stamp)
    for j, (told, true) in enumerate(zip(was, now, strict=True)):
        p_M = (CORNERS * told.half_extents).T
        apart = true.X_WM @ p_M - told.after(time) @ p_M
        far.append(np.linalg.norm(apart, axis=0).max() - reach(arrays, j, 0.0))
    return max(far)


def test_a_scenario_that_is_not_there_is_named(tmp_path):
    scenario = load(tmp_path, "ours")
    scenario.movers = [OtherRobot(scenario="Unknown")]
    with pytest.raises(RemoSplatError, match="Unknown"):
        build(scenario, load_world(scenario))
