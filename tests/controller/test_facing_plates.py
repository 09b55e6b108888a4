"""Two plates that are pressed on each other come to rest, without chatter."""

import dataclasses as dc

import numpy as np
import pytest
from programs import program_of
from pydrake.math import RigidTransform

from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.ingredients import SelfCollisionDamper
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

DT = 0.01
TICKS = 150
GAP = 0.06
URDF = """
<robot name="plates">
  <link name="lower"><collision><geometry><box size="0.4 0.4 0.02"/>
    </geometry></collision></link>
  <link name="slide"/>
  <link name="cradle"/>
  <link name="upper"><collision><geometry><box size="0.2 0.2 0.02"/>
    </geometry></collision></link>
  <joint name="lift" type="prismatic"><parent link="lower"/>
    <child link="slide"/><origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="pitch" type="revolute"><parent link="slide"/>
    <child link="cradle"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="roll" type="revolute"><parent link="cradle"/>
    <child link="upper"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
</robot>
"""
DESCRIPTION = f"""
name: plates
model: plates.urdf
arm: {{joints: [lift, pitch, roll], mount: lower}}
end_effector_frame: upper
velocity_limits: [1, 1, 1]
acceleration_limits: [20, 20, 20]
home: [{GAP - 0.08}, 0, 0]
spheres: {{covering: spheres.yaml}}
"""


@pytest.fixture
def plates(tmp_path) -> RobotModel:
    (tmp_path / "plates.urdf").write_text(URDF)
    (tmp_path / "plates.yaml").write_text(DESCRIPTION)
    (tmp_path / "spheres.yaml").write_text(
        "spheres: {lower: [[0, 0, 0, 0.3]], upper: [[0, 0, 0, 0.15]]}"
    )
    return load_robot(tmp_path / "plates.yaml")


@dc.dataclass
class Pressed:
    """Commands (TICKS, 3), distances and verification's fractions (TICKS,)."""

    u: np.ndarray
    distance: np.ndarray
    scale: np.ndarray


class NearestOnly(SelfCollisionDamper):
    """Looks at the nearest points of two shapes alone, not at corners."""

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds the first of the rows that the whole damper would."""
        damper = SelfCollisionDamper(self.config, tick.robot)
        whole = program_of(tick, [damper])
        for name, rows in whole.terms.rows.items():
            program.add_rows(name, rows.A[:1], rows.b[:1])


def press(robot: RobotModel, tilt: float, damper=None) -> Pressed:
    """Drives the upper plate to a target below the lower one."""
    config = gain_set("tuned")
    config.solver, config.guidance.enabled = "active_set", False
    config.joint_limits.influence, config.joint_limits.stop = 5.0, 1.0
    law = ReactiveLaw.make(config, robot, DT)
    if damper is not None:
        kept = [i for i in law.ingredients if type(i) is not damper.__base__]
        kept.append(damper(config.self_collision, robot))
        law = ReactiveLaw(robot, kept, DT, solver="active_set")
    pairs = SelfClearance.make(robot, 0.01)
    far = Box(RigidTransform([90.0, 0, 0]), np.full(3, 0.1))
    field = SignedDistanceField(PrimitiveScene(boxes=(far,)))
    q = robot.q_home + np.array([0, tilt, -0.5 * tilt])
    X_WT = robot.end_effector_pose(robot.q_home)
    X_WT[2, 3] -= 0.2
    u, run = np.zeros(3), Pressed(np.zeros((TICKS, 3)), *np.zeros((2, TICKS)))
    for k in range(TICKS):
        found = field.clearances(robot.spheres_at(q), law.collision.influence)
        report = run_tick(law, k * DT, q, X_WT, found, field, u)
        u = report.command
        q = robot.advance(q, u, DT)
        run.u[k], run.scale[k] = u, report.scale
        run.distance[k] = pairs.distances(q).min()
    return run


def flips(run: Pressed) -> int:
    """How often a command changes its mind by more than 1 mm/s or mrad/s.

    While the plates are farther apart than 3 cm, it may.
    """
    change = np.diff(run.u, axis=0)[run.distance[1:] < 0.03]
    turned = change[1:] * change[:-1] < 0
    return int((turned & (abs(change[1:]) > 1e-3)).sum())


@pytest.mark.parametrize("tilt", [0.0, 0.02, 0.2])
def test_plates_come_to_rest_where_they_must(plates, tilt):
    run = press(plates, tilt)
    assert (run.distance >= 0.01 - 1e-9).all()
    assert run.distance[-1] == pytest.approx(0.01, abs=2e-3)
    assert abs(run.u[-1]).max() < 0.01
    assert flips(run) <= 3
    assert (run.scale == 1.0).all()


@pytest.mark.parametrize("tilt", [0.0, 0.02])
def test_with_the_nearest_points_alone_they_chatter(plates, tilt):
    """So the test above can fail; verification keeps what it promises."""
    run = press(plates, tilt, NearestOnly)
    assert flips(run) > 20
    assert (run.scale < 1.0).sum() > 20
    assert (run.distance >= 0.01 - 1e-9).all()
