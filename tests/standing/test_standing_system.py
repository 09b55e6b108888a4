"""What closed loops say of a robot that something holds."""

import re
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import RunResult, run
from remosplat_drake.app.world import load_world
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.signals import standing as stands
from remosplat_drake.signals import thing as things

PLAIN = """
One:
  scene: {truth: scene.json}
  robot: {model: panda}
  oracle: !GroundTruth {}
  control_period: 0.02
  controller: {guidance: {enabled: false}}
  time_limit: 12
  targets:
  - {translation: %s, rpy_deg: [180, 0, 0]}
"""


def drive(
    folder: Path, target: list[float], *boxes: Box, text: str = "", **parts
) -> RunResult:
    """Drives a Panda without guidance among boxes to a target."""
    far = Box(RigidTransform([0.0, 0.0, -9.0]), np.full(3, 0.1), "far away")
    write_rmmi(folder / "scene.json", PrimitiveScene(boxes=(*boxes, far)))
    (folder / "test.yaml").write_text(PLAIN % target)
    scenario = load_scenario(f"{folder}/test.yaml:One", text)
    return run(build(scenario, load_world(scenario), **parts))


SHELF = Box(
    RigidTransform([0.55, 0, 0.25]), np.array([0.3, 0.6, 0.02]), "shelf"
)


def test_a_solid_is_called_by_its_name(tmp_path):
    result = drive(tmp_path, [0.5, 0.0, 0.05], SHELF)
    standing = result.standing
    assert standing.kind == stands.ENDED
    assert standing.cause == things.SOLID
    assert standing.thing == "the shelf"
    assert standing.link in ("panda_leftfinger", "panda_rightfinger")
    # On the shelf, and no nearer to the robot than the stopping distance.
    assert standing.p_W is not None and standing.clearance is not None
    assert abs(standing.p_W[2] - 0.27) < 1e-6
    assert 0.02 < standing.clearance < 0.03
    assert re.fullmatch(
        r"time limit: (left|right) finger held 2\d mm from the shelf,"
        r" 0\.\d\d m from the target",
        standing.text,
    )


def test_what_held_it_is_remembered(tmp_path):
    result = drive(tmp_path, [0.5, 0.0, 0.05], SHELF)
    told = [(s.kind, s.cause) for _, s in result.standings]
    assert told[0] == (stands.MOVING, "")
    assert (stands.HELD, things.SOLID) in told
    # It does not flicker: who is held stays so.
    assert len(told) <= 3
    times = [time for time, _ in result.standings]
    assert times == sorted(times)


def test_a_joint_limit(tmp_path):
    """What is above and behind the robot only a bent elbow would reach."""
    result = drive(tmp_path, [0.12, 0.0, 0.25])
    standing = result.standing
    assert standing.cause == stands.JOINT_LIMIT, standing.text
    assert "held at the" in standing.text and "limit of joint" in standing.text
    assert standing.p_W is not None


def test_out_of_reach(tmp_path):
    result = drive(tmp_path, [1.4, 0.0, 0.4])
    standing = result.standing
    assert standing.cause in (stands.NOTHING, stands.JOINT_LIMIT), standing.text


class Leash:
    """Keeps the hand from going to the left."""

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        J = tick.state.Jv_WE[1:2]
        program.add_rows("leash", J, np.zeros(1), lambda i: "panda_hand")


def test_a_constraint_of_somebody_else(tmp_path):
    result = drive(tmp_path, [0.4, 0.4, 0.4], ingredients=[Leash()])
    standing = result.standing
    assert standing.cause == stands.CONSTRAINT, standing.text
    assert "robot held by leash (hand)" in standing.text


def test_a_robot_that_arrives(tmp_path):
    result = drive(tmp_path, [0.45, 0.1, 0.4])
    assert (result.standing.kind, result.standing.text) == (
        stands.REACHED,
        "reached",
    )
    told = [s.kind for _, s in result.standings]
    assert told in ([stands.MOVING], [stands.MOVING, stands.REACHED])


def test_a_robot_that_is_stopped(tmp_path):
    text = "{supervisor: {robot_modes: [guiding]}}"
    result = drive(tmp_path, [0.45, 0.1, 0.4], text=text)
    assert result.standing.kind == stands.STOPPED
    assert result.standing.text.startswith(
        "stopped: the arm's mode is move; waiting for an operator, 0."
    )
